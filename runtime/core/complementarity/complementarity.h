/* The linear complementarity problem with a symmetric matrix; see complementarity.c. */
#ifndef CCGEN_COMPLEMENTARITY_H
#define CCGEN_COMPLEMENTARITY_H

#include "base/arena.h"

/* 0 <= P, 0 <= z = W P + b, P.z = 0 for symmetric positive semidefinite W[n][n].
 * Where W is singular the impulses of least norm are taken. Returns 0, or 1 when memory or iterations run out. */
int solve_complementarity(struct arena *arena, int n, const double *W, const double *b, double *P);

#endif
