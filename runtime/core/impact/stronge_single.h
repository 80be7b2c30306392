/* Stronge's law at one contact; see stronge_single.c. */
#ifndef CCGEN_STRONGE_SINGLE_H
#define CCGEN_STRONGE_SINGLE_H

#include "base/real.h"

/* One contact: W[4] are the rates of its normal, then of its tangent, that unit impulses along them give; rate[2] before, m/s.
 * Impulses *P >= 0 and *F in N s. Returns 0, or 1 where compression does not end: friction jams. */
int stronge_single(const double *W, double mu, double e, const double *rate, double *P, double *F);

#endif
