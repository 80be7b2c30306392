/* Sines and cosines of many angles at once, in vector lanes.
 *
 * Reduction by multiples of pi/2 in three parts (W. J. Cody, W. Waite, Software Manual for the Elementary Functions, 1980)
 * and the minimax polynomials of the freely distributable math library (fdlibm, Sun Microsystems 1993, k_sin and k_cos).
 * The error stays about one unit in the last place (tests hold it below two). Angles beyond CCGEN_ANGLE_LIMIT, for which the
 * reduction would need more parts, and angles that are not finite go to the C library.
 */
#ifndef CCGEN_SINCOS_H
#define CCGEN_SINCOS_H

#include <math.h>
#include <string.h>

#if defined(CCGEN_LANES) /* asked for */
#elif defined(__AVX512F__)
#define CCGEN_LANES 8
#elif defined(__AVX__)
#define CCGEN_LANES 4
#else
#define CCGEN_LANES 2
#endif

#define CCGEN_ANGLE_LIMIT 65536.0

typedef double ccgen_lanes __attribute__((vector_size(8 * CCGEN_LANES)));
typedef long long ccgen_mask __attribute__((vector_size(8 * CCGEN_LANES)));

#define CCGEN_SELECT(mask, yes, no) ((ccgen_lanes)(((mask) & (ccgen_mask)(yes)) | (~(mask) & (ccgen_mask)(no))))

/* sine and cosine of the angles, each at most CCGEN_ANGLE_LIMIT in size */
static inline void ccgen_sincos_lanes(const ccgen_lanes *angles, ccgen_lanes *c, ccgen_lanes *s)
{
    const ccgen_lanes x = *angles;
    const double round = 6755399441055744.0; /* 1.5 * 2^52: adding it leaves the nearest integer in the low bits */
    const ccgen_lanes shifted = x * 6.36619772367581382433e-01 + round, n = shifted - round;
    const ccgen_mask quadrant = (ccgen_mask)shifted;
    const ccgen_lanes first = x - n * 1.57079632673412561417e+00, second = n * 6.07710050630396597660e-11;
    const ccgen_lanes r = first - second; /* the products are exact; what the difference loses goes into the tail */
    const ccgen_lanes tail = ((first - r) - second) - n * 2.02226624879595063154e-21;
    const ccgen_lanes z = r * r;
    const ccgen_lanes sine =
        r + (r * z *
                 (-1.66666666666666324348e-01 +
                  z * (8.33333333332248946124e-03 +
                       z * (-1.98412698298579493134e-04 +
                            z * (2.75573137070700676789e-06 +
                                 z * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10))))) +
             tail);
    const ccgen_lanes half = 0.5 * z, most = 1.0 - half;
    const ccgen_lanes cosine =
        most + (((1.0 - most) - half) +
                (z * z *
                     (4.16666666666666019037e-02 +
                      z * (-1.38888888888741095749e-03 +
                           z * (2.48015872894767294178e-05 +
                                z * (-2.75573143513906633035e-07 +
                                     z * (2.08757232129817482790e-09 + z * -1.13596475577881948265e-11))))) -
                 r * tail));
    const ccgen_mask odd = -(quadrant & 1), sign_s = (quadrant & 2) << 62, sign_c = ((quadrant + 1) & 2) << 62;
    *s = (ccgen_lanes)((ccgen_mask)CCGEN_SELECT(odd, cosine, sine) ^ sign_s);
    *c = (ccgen_lanes)((ccgen_mask)CCGEN_SELECT(odd, sine, cosine) ^ sign_c);
}

/* lanes where they lie in arrays of doubles, value i of lane l at [i * CCGEN_LANES + l] */
typedef double ccgen_stored __attribute__((vector_size(8 * CCGEN_LANES), aligned(8), may_alias));

/* one block of lanes; those beyond the limit are noted */
static inline void ccgen_sincos_block(const double *x, double *c, double *s, ccgen_mask *beyond)
{
    const ccgen_lanes in = *(const ccgen_stored *)x;
    ccgen_lanes cosine, sine;
    *beyond |= ~((in <= CCGEN_ANGLE_LIMIT) & (in >= -CCGEN_ANGLE_LIMIT));
    ccgen_sincos_lanes(&in, &cosine, &sine);
    *(ccgen_stored *)c = cosine;
    *(ccgen_stored *)s = sine;
}

/* c[i] = cos(x[i]), s[i] = sin(x[i]) for i < count. The last block ends with the last angle, so that it is as whole as the
 * others: what it shares with the one before is computed twice. */
static inline void ccgen_sincos(size_t count, const double *x, double *c, double *s)
{
    ccgen_mask beyond = {0};
    if (count < CCGEN_LANES) {
        double few[3][CCGEN_LANES] = {{0.0}};
        for (size_t i = 0; i < count; i++)
            few[0][i] = x[i];
        ccgen_sincos_block(few[0], few[1], few[2], &beyond);
        for (size_t i = 0; i < count; i++) {
            c[i] = few[1][i];
            s[i] = few[2][i];
        }
    } else {
        size_t i = 0;
        for (; i + CCGEN_LANES <= count; i += CCGEN_LANES)
            ccgen_sincos_block(x + i, c + i, s + i, &beyond);
        if (i < count) {
            i = count - CCGEN_LANES;
            ccgen_sincos_block(x + i, c + i, s + i, &beyond);
        }
    }
    long long any = 0;
    for (int j = 0; j < CCGEN_LANES; j++)
        any |= beyond[j];
    for (size_t i = 0; any && i < count; i++) {
        c[i] = cos(x[i]);
        s[i] = sin(x[i]);
    }
}

#endif
