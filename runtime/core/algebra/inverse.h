/* Inverses of small matrices that are surely regular; see inverse.c. */
#ifndef CCGEN_INVERSE_H
#define CCGEN_INVERSE_H

#include "base/real.h"

/* inverse[n][n] of W[n][n], in scratch[n][2 n + 2]; 0 where W may be singular, and the inverse is not to be used: where roots of its
 * diagonal differ by more than 1 / sure, or the condition of the matrix that is left when they are divided by, rows and columns, is more */
int invert_sure(int n, const double *W, double sure, double *inverse, double *scratch);

#endif
