/* Arithmetic over equal modules: one quantity of CCGEN_ABREAST modules of a mechanism, side by side, in one vector.
 *
 * Compilers make two vectors of one that is wider than the machine's. Functions of the C library work lane by lane.
 */
#ifndef CCGEN_ABREAST_H
#define CCGEN_ABREAST_H

#include "model.h"

/* GCC tells that vectors wider than the machine's are passed to functions in other ways than they once were. All functions
 * that take them are in this file. */
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wpsabi"
#endif

typedef double ccgen_abreast __attribute__((vector_size(8 * CCGEN_ABREAST)));

/* the same where they lie in arrays of doubles */
typedef double ccgen_abreast_stored __attribute__((vector_size(8 * CCGEN_ABREAST), aligned(8), may_alias));

typedef long long ccgen_abreast_mask __attribute__((vector_size(8 * CCGEN_ABREAST)));

/* the sum over all modules */
static inline double ccgen_total(ccgen_abreast x)
{
    double sum = x[0];
    for (int l = 1; l < CCGEN_ABREAST; l++)
        sum += x[l];
    return sum;
}

/* whether the quantity is positive in all modules */
static inline int ccgen_positive(ccgen_abreast x)
{
    const ccgen_abreast_mask positive = x > 0.0;
    long long all = -1;
    for (int l = 0; l < CCGEN_ABREAST; l++)
        all &= positive[l];
    return (int)all;
}

#define CCGEN_EACH(function) \
    static inline ccgen_abreast ccgen_each_##function(ccgen_abreast x) \
    { \
        for (int l = 0; l < CCGEN_ABREAST; l++) \
            x[l] = function(x[l]); \
        return x; \
    }

CCGEN_EACH(sin)
CCGEN_EACH(cos)
CCGEN_EACH(tan)
CCGEN_EACH(atan)
CCGEN_EACH(exp)
CCGEN_EACH(log)
CCGEN_EACH(tanh)
CCGEN_EACH(fabs)
CCGEN_EACH(sqrt)
CCGEN_EACH(unit_step)

#define CCGEN_ONE_OR_EACH(function, x) _Generic((x), double: function, default: ccgen_each_##function)(x)

#define sin(x) CCGEN_ONE_OR_EACH(sin, x)
#define cos(x) CCGEN_ONE_OR_EACH(cos, x)
#define tan(x) CCGEN_ONE_OR_EACH(tan, x)
#define atan(x) CCGEN_ONE_OR_EACH(atan, x)
#define exp(x) CCGEN_ONE_OR_EACH(exp, x)
#define log(x) CCGEN_ONE_OR_EACH(log, x)
#define tanh(x) CCGEN_ONE_OR_EACH(tanh, x)
#define fabs(x) CCGEN_ONE_OR_EACH(fabs, x)
#define sqrt(x) CCGEN_ONE_OR_EACH(sqrt, x)
#define unit_step(x) CCGEN_ONE_OR_EACH(unit_step, x)

#endif
