/* Flight, and motion with held contacts: smooth, step by step, to the end of a run or to the first event. */
#ifndef CCGEN_PHASE_H
#define CCGEN_PHASE_H

#include "steps/step.h"

/* smooth motion, in flight or with held contacts, to the end of the run or to the first event: that of event->contact,
 * which is -1 when there is none */
enum outcome integrate_to_event(struct phase *f, struct event *event);

/* Arrays of a flight, whose system and run are set, and of its active set, which becomes the system's, from the system's arena; 0, or 1
 * when memory runs out. */
int take_phase(struct phase *f);

#endif
