/* Flight, and motion with held contacts: smooth, step by step, to the end of a run or to the first event. */
#ifndef CCGEN_PHASE_H
#define CCGEN_PHASE_H

#include "steps/step.h"

/* smooth motion, in flight or with held contacts, to the end of the run or to the first event: that of event->contact,
 * which is -1 when there is none */
enum outcome integrate_to_event(struct phase *f, struct event *event);

/* The time (s) in which a run may spend its budget of steps and events: a characteristic time; a tenth of the duration where that is less, a
 * ten-thousandth where that is more, for a run that would take forever is to end */
double window_of(const struct phase *f);

/* Whether a twentieth of the steps that a window may have, in a row, have each moved less than is known where links lie in a line */
int is_crawling(const struct phase *f);

/* Arrays of a flight, whose system and run are set, and of its active set, which becomes the system's, from the system's arena; 0, or 1
 * when memory runs out. */
int take_phase(struct phase *f);

#endif
