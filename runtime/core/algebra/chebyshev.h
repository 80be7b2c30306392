/* Interpolation at the Chebyshev points of the first kind (J.-P. Berrut, L. N. Trefethen, SIAM Review 46, 2004). */
#ifndef CCGEN_CHEBYSHEV_H
#define CCGEN_CHEBYSHEV_H

#include "base/real.h"

/* Point number i of `count`, -1 < x < 1, from the largest on */
double chebyshev_point(int count, int i);

/* weight[count] with which values at these points give that of their polynomial at x */
void chebyshev_weights(int count, double x, double *weight);

/* weight[count] with which they give its Chebyshev coefficient number k */
void chebyshev_coefficient(int count, int k, double *weight);

#endif
