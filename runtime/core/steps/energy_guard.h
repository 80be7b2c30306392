/* Whether a step keeps the energy; see energy_guard.c. */
#ifndef CCGEN_ENERGY_GUARD_H
#define CCGEN_ENERGY_GUARD_H

#include "steps/step.h"

/* what the step to y1 gains or loses, other than by the work of effects, in units of what may be: more than 1 is refused. *unknown: J, of that what a place that it passes by
 * may hide, but is not likely to; 0 else */
double energy_residual(struct phase *f, double *unknown);

/* whether a step of fixed length gains or loses so much that it is no step of the motion */
int breaks_energy(struct phase *f);

/* the step to y1 is taken, f->t and f->y not changed yet */
void commit_energy(struct phase *f);

#endif
