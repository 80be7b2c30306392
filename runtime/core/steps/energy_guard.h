/* Whether a step keeps the energy; see energy_guard.c. */
#ifndef CCGEN_ENERGY_GUARD_H
#define CCGEN_ENERGY_GUARD_H

#include "steps/step.h"

/* what the step to y1 gains or loses, other than by the work of effects, in units of what may be: more than 1 is refused */
double energy_missed(struct flight *f);

/* whether a step of fixed length gains or loses so much that it is no step of the motion */
int energy_lost(struct flight *f);

/* the step to y1 is taken, f->t and f->y not changed yet */
void energy_taken(struct flight *f);

#endif
