/* Linear systems with symmetric positive semidefinite matrices; see semidefinite.c. */
#ifndef CCGEN_SEMIDEFINITE_H
#define CCGEN_SEMIDEFINITE_H

#include "base/real.h"

/* x[n] of least norm with W x = r for symmetric positive semidefinite W[n][n]; `scratch` has semidefinite_scratch(n) numbers. */
size_t semidefinite_scratch(int n);
void solve_semidefinite(int n, const double *W, const double *r, double *x, double *scratch);

/* x[n] <- W^-1 x for symmetric W[n][n], `scratch` [n][n]; nonzero where it is not well away from losing rank. */
int solve_definite_well(int n, const double *W, double *x, double *scratch);

#endif
