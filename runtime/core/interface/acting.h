/* What events of the scene do; see acting.c. */
#ifndef CCGEN_ACTING_H
#define CCGEN_ACTING_H

#include "interface/simulation.h"

/* Do what the events say at which the run has halted: set parameters, and begin anew from the state; where that cannot be nothing is set. *ends is whether one
 * of them ends the run. */
enum outcome act(struct ccgen_simulation *it, int *ends);

#endif
