/* Sines and cosines by the C library, one state at a time: for models in numbers that the machine has no vectors of.
 *
 * CCGEN_OF_TYPE gives the library's function for those numbers. */
#ifndef CCGEN_ONE_LANE_H
#define CCGEN_ONE_LANE_H

#include <math.h>
#include <stddef.h>

#define CCGEN_LANES 1

/* c[i] = cos(x[i]), s[i] = sin(x[i]) for i < count */
static inline void ccgen_sincos(size_t count, const double *x, double *c, double *s)
{
    for (size_t i = 0; i < count; i++) {
        c[i] = CCGEN_OF_TYPE(cos)(x[i]);
        s[i] = CCGEN_OF_TYPE(sin)(x[i]);
    }
}

#endif
