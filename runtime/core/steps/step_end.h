/* The end of a step: put back onto the closure, and past a singular configuration to its energy; see step_end.c. */
#ifndef CCGEN_STEP_END_H
#define CCGEN_STEP_END_H

#include "steps/step.h"

/* Move the end y1 of a step of length h, put back already, by no more than is unknown of it, to the energy that the step began with. In *excess what
 * that energy misses still, by what the tolerance lets it miss; 0 where nothing is unknown, or the energy does not tell. */
enum outcome return_to_energy(struct phase *f, double h, double *excess);

/* step of length h from (t, y) to y1, put back onto the closure whatever its error */
enum outcome projected_step(struct phase *f, double h);

#endif
