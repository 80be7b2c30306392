/* Gaussian elimination with exchange of rows, for matrices without symmetry; see elimination.c. */
#ifndef CCGEN_ELIMINATION_H
#define CCGEN_ELIMINATION_H

#include "base/real.h"

/* x <- a^-1 x; a[n][n] is destroyed. Returns the sign of the determinant of a, or 0 where a pivot is below the share `least`
 * of its row as it was: x is then not to be used. */
int eliminate(int n, double *a, double *x, double least);

/* For a[rows][n] whose rows may depend on each other, and agree: z with a z = x, of which z[order[k]] = x[k] for k below the rank that
 * is returned, and the others are 0. Pivots below the share `least` of their rows are rounding. a is destroyed. */
int eliminate_dependent(int rows, int n, double *a, double *x, int *order, double least);

#endif
