/* Linear systems with symmetric positive semidefinite matrices; see semidefinite.c. */
#ifndef CCGEN_SEMIDEFINITE_H
#define CCGEN_SEMIDEFINITE_H

#include "algebra/orthogonal.h"

/* Room for a system of n unknowns */
struct semidefinite {
    double *a, *right, *diagonal, *beta; /* [n][n], [n] */
    int *order;                          /* [n] */
    struct least_norm least_norm;
};

void take_semidefinite(struct arena *arena, struct semidefinite *room, size_t n);

/* x[n] of least norm with W x = r for symmetric positive semidefinite W[n][n], in room for n or more unknowns */
void solve_semidefinite(int n, const double *W, const double *r, double *x, struct semidefinite *room);

/* x[n] <- W^-1 x for symmetric W[n][n], `scratch` [n][n]; nonzero where it is not well away from losing rank. */
int solve_definite_well(int n, const double *W, double *x, double *scratch);

#endif
