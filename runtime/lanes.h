/* Arithmetic over lanes: one value of several states, side by side, in one vector of the machine.
 *
 * A kernel over lanes reads like the kernel of one state: vectors take part in sums and products as numbers do, and a number
 * beside a vector stands for all its lanes. Their width is that of the machine that the model is compiled for (sincos.h).
 * Functions of the C library work on vectors here lane by lane, sines and cosines all together.
 */
#ifndef CCGEN_LANES_H
#define CCGEN_LANES_H

#include "model.h"
#include "sincos.h"

/* a number, or a vector, as a vector */
#define CCGEN_ALL(x) ((ccgen_lanes){0.0} + (x))

#define CCGEN_LANEWISE(function) \
    static inline ccgen_lanes ccgen_##function##_lanes(ccgen_lanes x) \
    { \
        for (int l = 0; l < CCGEN_LANES; l++) \
            x[l] = function(x[l]); \
        return x; \
    } \
    static inline double ccgen_##function##_one(double x) { return function(x); }

CCGEN_LANEWISE(sin)
CCGEN_LANEWISE(cos)
CCGEN_LANEWISE(tan)
CCGEN_LANEWISE(exp)
CCGEN_LANEWISE(log)
CCGEN_LANEWISE(tanh)
CCGEN_LANEWISE(fabs)
CCGEN_LANEWISE(sqrt)
CCGEN_LANEWISE(unit_step)

#define CCGEN_EITHER(function, x) _Generic((x), double: ccgen_##function##_one, default: ccgen_##function##_lanes)(x)

/* c[i], s[i] = cosines and sines of x[i] for i < count, all lanes of each */
static inline void ccgen_sincos_stored(int count, const ccgen_stored *x, ccgen_lanes *c, ccgen_lanes *s)
{
    ccgen_mask beyond = {0};
    for (int i = 0; i < count; i++) {
        const ccgen_lanes angle = x[i];
        beyond |= ~((angle <= CCGEN_ANGLE_LIMIT) & (angle >= -CCGEN_ANGLE_LIMIT));
        ccgen_sincos_lanes(&angle, &c[i], &s[i]);
    }
    long long any = 0;
    for (int l = 0; l < CCGEN_LANES; l++)
        any |= beyond[l];
    for (int i = 0; any && i < count; i++) {
        c[i] = ccgen_cos_lanes(x[i]);
        s[i] = ccgen_sin_lanes(x[i]);
    }
}

/* the lanes in which a mask is set, as bits: lane l is bit l */
static inline unsigned ccgen_bits(ccgen_mask mask)
{
    unsigned bits = 0;
    for (int l = 0; l < CCGEN_LANES; l++)
        bits |= (unsigned)(mask[l] & 1) << l;
    return bits;
}

/* sums over stages for a method whose stages lie in lanes (`ccgen_stages` of model.h) */
static inline void ccgen_stages_stored(int n, int stages, const double *base, const double *slope, const double *node,
                                       const double *matrix, const double *x, double *out)
{
    const ccgen_stored *rows = (const ccgen_stored *)matrix, *at = (const ccgen_stored *)node;
    ccgen_stored *sums = (ccgen_stored *)out;
    for (int i = 0; i < n; i++) {
        const double *terms = x + (size_t)i * stages;
        ccgen_lanes even = rows[0] * terms[0], odd = rows[1] * terms[1];
        for (int j = 2; j < stages; j += 2) {
            even += rows[j] * terms[j];
            odd += rows[j + 1] * terms[j + 1];
        }
        sums[i] = (base[i] + slope[i] * at[0]) + (even + odd);
    }
}

#endif
