/* How motion goes on, with the events of its scene; ../../ccgen.h has the calls. */
#ifndef CCGEN_CALLS_H
#define CCGEN_CALLS_H

#include "interface/simulation.h"

/* Go on to `until`, past all events, or, if the run halts at events of its scene, to the first of these: *halts is whether there is one. */
enum outcome simulate(struct ccgen_simulation *s, double until, int *halts);

/* Go on to `until`, through all that events do; *ends is whether one of them has ended the run. */
enum outcome simulate_through_events(struct ccgen_simulation *it, double until, int *ends);

#endif
