/* Gaussian elimination with exchange of rows, for matrices without symmetry; see elimination.c. */
#ifndef CCGEN_ELIMINATION_H
#define CCGEN_ELIMINATION_H

#include "real.h"

/* x <- a^-1 x; a[n][n] is destroyed. Returns the sign of the determinant of a, or 0 where a pivot is below the share `least`
 * of its row as it was: x is then not to be used. */
int eliminate(int n, double *a, double *x, double least);

#endif
