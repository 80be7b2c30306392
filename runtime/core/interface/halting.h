/* Motion up to events of the scene; see halting.c. */
#ifndef CCGEN_HALTING_H
#define CCGEN_HALTING_H

#include "interface/simulation.h"

/* Go on to `until`, or to the first event of the scene whose count of those that are let pass is spent, or, if `to_event`, past the next event of contacts. */
enum outcome go_on_to_crossing(struct ccgen_simulation *it, double until, int to_event, struct met *met);

/* Back to before the step that holds the event at which the run has halted: it comes to it again. */
void go_before_halt(struct ccgen_simulation *it);

#endif
