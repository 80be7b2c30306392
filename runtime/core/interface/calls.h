/* How motion goes on, with the events of its scene; ../../ccgen.h has the calls. */
#ifndef CCGEN_CALLS_H
#define CCGEN_CALLS_H

#include "interface/simulation.h"

/* Go on to `until`, past all events, or, if the run halts at events of its scene, to the first of these: *halts is whether there is one. */
enum outcome simulate(struct ccgen_simulation *s, double until, int *halts);

#endif
