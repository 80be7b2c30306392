/* Whether numbers from outside are in order; see within.c. */
#ifndef CCGEN_WITHIN_H
#define CCGEN_WITHIN_H

#include "base/real.h"

/* Whether n numbers are all no larger than `limit` in size, to rounding, or finite; what is not a number is neither. */
int all_within(size_t n, const double *x, double limit);
int all_finite(size_t n, const double *x);

#endif
