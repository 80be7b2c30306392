/* Cholesky's factorisation L D L^T of symmetric positive definite matrices, without square roots: a matrix twice as large has the
 * same L, to the last bit. */
#ifndef CCGEN_CHOLESKY_H
#define CCGEN_CHOLESKY_H

#include "base/real.h"

/* Factor of W[n][n] over the indices set[m] (the first m where it is NULL), in the lower triangle of a[m][m], D on its diagonal; a may be W itself
 * where all indices are meant. 0, or 1 where an index is nearer to those before it than the share `dependent` of its own entry. */
int cholesky(int n, const double *W, int m, const int *set, double dependent, double *a);

/* x[m] <- (L D L^T)^-1 x for the factor a[m][m] */
void cholesky_solve(int m, const double *a, double *x);

#endif
