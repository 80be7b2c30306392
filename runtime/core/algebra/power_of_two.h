/* Powers of two, by which numbers are scaled without rounding. */
#ifndef CCGEN_POWER_OF_TWO_H
#define CCGEN_POWER_OF_TWO_H

#include "base/real.h"

/* The least power of two above |x|; 1 for zero and for what is no finite number */
static inline double power_of_two(double x)
{
    int exponent;
    if (!isfinite(x) || x == 0.0)
        return 1.0;
    frexp(x, &exponent);
    return ldexp(1.0, exponent);
}

static inline void multiply(int n, double by, double *x)
{
    for (int i = 0; i < n; i++)
        x[i] *= by;
}

#endif
