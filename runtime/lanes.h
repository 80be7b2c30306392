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
CCGEN_LANEWISE(atan)
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

/* a vector from f(l, by) of each lane l */
#if CCGEN_LANES == 8
#define CCGEN_EACH_LANE(f, by) {f(0, by), f(1, by), f(2, by), f(3, by), f(4, by), f(5, by), f(6, by), f(7, by)}
#elif CCGEN_LANES == 4
#define CCGEN_EACH_LANE(f, by) {f(0, by), f(1, by), f(2, by), f(3, by)}
#else
#define CCGEN_EACH_LANE(f, by) {f(0, by), f(1, by)}
#endif

/* Of as many vectors as there are lanes, lane l + by of vector i and lane l of vector i + by change places, for all i and l in
 * which the bit `by` is not set. Compilers know each line as one instruction. */
#define CCGEN_UPPER(l, by) ((l) & (by) ? b[(l) ^ (by)] : a[l])
#define CCGEN_LOWER(l, by) ((l) & (by) ? b[l] : a[(l) ^ (by)])
#define CCGEN_EXCHANGE(x, by) \
    _Pragma("GCC unroll 8") for (int i = 0; i < CCGEN_LANES; i++) \
    { \
        if (i & (by)) \
            continue; \
        const ccgen_lanes a = x[i], b = x[i | (by)]; \
        x[i] = (ccgen_lanes)CCGEN_EACH_LANE(CCGEN_UPPER, by); \
        x[i | (by)] = (ccgen_lanes)CCGEN_EACH_LANE(CCGEN_LOWER, by); \
    }

/* to[i][l] = from[l][i] for as many i as there are lanes; rows of each are `stride` numbers apart */
static inline __attribute__((always_inline)) void ccgen_turn(const double *from, size_t from_stride, double *to, size_t to_stride)
{
    ccgen_lanes x[CCGEN_LANES];
    _Pragma("GCC unroll 8") for (int i = 0; i < CCGEN_LANES; i++)
        x[i] = *(const ccgen_stored *)(from + i * from_stride);
    CCGEN_EXCHANGE(x, 1)
#if CCGEN_LANES > 2
    CCGEN_EXCHANGE(x, 2)
#endif
#if CCGEN_LANES > 4
    CCGEN_EXCHANGE(x, 4)
#endif
    _Pragma("GCC unroll 8") for (int i = 0; i < CCGEN_LANES; i++)
        *(ccgen_stored *)(to + i * to_stride) = x[i];
}

/* n numbers of as many states as lanes, one state after the other, lane beside lane. The last square ends with the last
 * number: what it shares with the one before is moved twice. Inlined, since n is known where it is called. */
static inline __attribute__((always_inline)) void ccgen_lanes_of_states(int n, const double *states, ccgen_lanes *lanes)
{
    double *to = (double *)lanes;
    for (int i = 0; n < CCGEN_LANES && i < n; i++)
        for (int l = 0; l < CCGEN_LANES; l++)
            to[i * CCGEN_LANES + l] = states[l * n + i];
    for (int i = 0; n >= CCGEN_LANES && i < n; i += CCGEN_LANES) {
        const int first = i + CCGEN_LANES <= n ? i : n - CCGEN_LANES;
        ccgen_turn(states + first, n, to + first * CCGEN_LANES, CCGEN_LANES);
    }
}

/* and back */
static inline __attribute__((always_inline)) void ccgen_states_of_lanes(int n, const ccgen_lanes *lanes, double *states)
{
    const double *from = (const double *)lanes;
    for (int i = 0; n < CCGEN_LANES && i < n; i++)
        for (int l = 0; l < CCGEN_LANES; l++)
            states[l * n + i] = from[i * CCGEN_LANES + l];
    for (int i = 0; n >= CCGEN_LANES && i < n; i += CCGEN_LANES) {
        const int first = i + CCGEN_LANES <= n ? i : n - CCGEN_LANES;
        ccgen_turn(from + first * CCGEN_LANES, CCGEN_LANES, states + first, n);
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

/* the lanes, as bits, in which one of n numbers is not finite */
static inline unsigned ccgen_not_finite(int n, const ccgen_lanes *x)
{
    ccgen_lanes none = {0.0};
    for (int i = 0; i < n; i++)
        none += 0.0 * x[i];
    return ccgen_bits(none != 0.0);
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
