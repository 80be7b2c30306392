/* Systems whose rows depend on each other; see dependent.c. */
#ifndef CCGEN_DEPENDENT_H
#define CCGEN_DEPENDENT_H

#include "base/arena.h"

/* x[n] with W x = r of the least sum of (x / weight)^2. W[n][n], with a diagonal of no zeros, r[n] and weight[n] stay. 0; 1 where rows nearly depend on each other, so that
 * digits are lost, where r is not what W reaches, or memory runs out */
int solve_dependent(struct arena *arena, int n, const double *W, const double *r, const double *weight, double *x);

#endif
