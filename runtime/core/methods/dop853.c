/* DOP853: explicit Runge-Kutta of order 8 with error estimates of order 5 and 3 and dense output of order 7
 * (E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, 1993, section II.5 and II.6). */
#include "methods/method.h"

#include <math.h>
#include <string.h>

#include "methods/dop853_tableau.h"
#include "motion/derivative.h"

/* scratch: DENSE_STAGES derivatives and a state, DENSE_DEGREE coefficients and the start of the interpolant, ESTIMATES */
enum { ESTIMATES = 2 };            /* of order 3 and of order 5 */
static const double CHANCE = 0.01; /* how far below what the other says the estimate of order 5 is believed */

static double *stage(double *scratch, int size, int i)
{
    return scratch + (size_t)i * size;
}

static double *coefficient(double *scratch, int size, int i)
{
    return scratch + (size_t)(DENSE_STAGES + 1 + i) * size;
}

static double *estimate(double *scratch, int size, int i)
{
    return scratch + (size_t)(DENSE_STAGES + 1 + DENSE_DEGREE + 1 + i) * size;
}

static size_t dop853_scratch(const struct system *s)
{
    return (size_t)(DENSE_STAGES + 1 + DENSE_DEGREE + 1 + ESTIMATES) * s->size;
}

/* sums[size] of a[j] k_j over the first `count` stages in turn. Four are added at a time, so that sums are read and written a quarter as
 * often. */
static void weigh(const double *stages, int size, const double *a, int count, double *restrict sums)
{
    double w[4];
    const double *k[4];
    int taken = 0;
    memset(sums, 0, size * sizeof *sums);
    for (int j = 0; j < count; j++) {
        if (a[j] == 0.0)
            continue;
        w[taken] = a[j];
        k[taken++] = stages + (size_t)j * size;
        if (taken < 4)
            continue;
        const double *k0 = k[0], *k1 = k[1], *k2 = k[2], *k3 = k[3];
        for (int i = 0; i < size; i++)
            sums[i] = sums[i] + w[0] * k0[i] + w[1] * k1[i] + w[2] * k2[i] + w[3] * k3[i];
        taken = 0;
    }
    for (int j = 0; j < taken; j++)
        for (int i = 0; i < size; i++)
            sums[i] += w[j] * k[j][i];
}

/* out = y + h sum_j a[j] k_j over the first `count` stages */
static void combine(const double *stages, int size, const double *a, int count, double h, const double *y,
                    double *restrict out)
{
    weigh(stages, size, a, count, out);
    for (int i = 0; i < size; i++)
        out[i] = y[i] + h * out[i];
}

static enum outcome dop853_step(struct system *s, double *scratch, double t, double h, struct tolerance tolerance,
                                const double *y, const double *dy, double *y1)
{
    (void)tolerance;
    const int size = s->size;
    double *at = stage(scratch, size, DENSE_STAGES);
    memcpy(stage(scratch, size, 0), dy, size * sizeof *dy);
    for (int i = 1; i < STAGES; i++) {
        combine(scratch, size, A[i], i, h, y, at);
        const enum outcome outcome = system_derivative(s, t + C[i] * h, at, stage(scratch, size, i));
        if (outcome)
            return outcome;
    }
    combine(scratch, size, B, STAGES, h, y, y1);
    double *error3 = estimate(scratch, size, 0), *error5 = estimate(scratch, size, 1);
    weigh(scratch, size, E3, STAGES, error3);
    weigh(scratch, size, E5, STAGES, error5);
    for (int i = 0; i < size; i++) {
        error3[i] *= h;
        error5[i] *= h;
    }
    return OUTCOME_DONE;
}

static double *dop853_estimates(double *scratch, int size, int *count)
{
    *count = ESTIMATES;
    return estimate(scratch, size, 0);
}

/* Both estimates together (Hairer, Norsett, Wanner 1993, section II.10): as small as the better, as reliable as the other.
 * Against the motion itself they shrink as h^3 and h^5, so the better is about the motion times the other's part of it to 5/3.
 * One far below that vanishes by chance, as in much too long steps it may, and is not believed. */
static double dop853_measure(const double *scratch, int size, struct tolerance tolerance, const double *y,
                             const double *y1)
{
    const double *error3 = scratch + (size_t)(DENSE_STAGES + 1 + DENSE_DEGREE + 1) * size, *error5 = error3 + size;
    double sum3 = 0.0, sum5 = 0.0, motion = 0.0;
    for (int i = 0; i < size; i++) {
        const double scale = allowed_error(tolerance, i, fmax(fabs(y[i]), fabs(y1[i]))),
                     change = (y1[i] - y[i]) / scale;
        sum3 += (error3[i] / scale) * (error3[i] / scale);
        sum5 += (error5[i] / scale) * (error5[i] / scale);
        motion += change * change;
    }
    if (motion > 0.0)
        sum5 = fmax(sum5, CHANCE * CHANCE * sum3 * pow(sum3 / motion, 2.0 / 3.0));
    if (!isfinite(sum3 + sum5)) /* a quotient of such numbers may be 0 */
        return INFINITY;
    return sum5 > 0.0 ? sum5 / sqrt((sum5 + 0.01 * sum3) * size) : 0.0;
}

static enum outcome dop853_prepare(struct system *s, double *scratch, double t, double h, const double *y,
                                   const double *dy, const double *y1, const double *dy1)
{
    const int size = s->size;
    double *at = coefficient(scratch, size, DENSE_DEGREE);
    memcpy(stage(scratch, size, STAGES), dy1, size * sizeof *dy1);
    for (int i = STAGES + 1; i < DENSE_STAGES; i++) {
        combine(scratch, size, A[i], i, h, y, at);
        const enum outcome outcome = system_derivative(s, t + C[i] * h, at, stage(scratch, size, i));
        if (outcome)
            return outcome;
    }
    for (int i = 0; i < size; i++) {
        const double difference = y1[i] - y[i];
        coefficient(scratch, size, 0)[i] = difference;
        coefficient(scratch, size, 1)[i] = h * dy[i] - difference;
        coefficient(scratch, size, 2)[i] = 2.0 * difference - h * (dy1[i] + dy[i]);
    }
    for (int d = 3; d < DENSE_DEGREE; d++) {
        double *of = coefficient(scratch, size, d);
        weigh(scratch, size, D[d - 3], DENSE_STAGES, of);
        for (int i = 0; i < size; i++)
            of[i] *= h;
    }
    memcpy(at, y, size * sizeof *y);
    return OUTCOME_DONE;
}

static void dop853_interpolate(const double *scratch, int size, double theta, double *y)
{
    const double *f = scratch + (size_t)(DENSE_STAGES + 1) * size;
    for (int i = 0; i < size; i++) {
        double sum = 0.0;
        for (int d = DENSE_DEGREE - 1; d >= 0; d--)
            sum = (sum + f[(size_t)d * size + i]) * (d % 2 ? 1.0 - theta : theta);
        y[i] = f[(size_t)DENSE_DEGREE * size + i] + sum;
    }
}

const struct method dop853 = {
    .name = "dop853",
    .order = 8,
    .derivatives = 1,
    .scratch = dop853_scratch,
    .step = dop853_step,
    .estimates = dop853_estimates,
    .measure = dop853_measure,
    .prepare = dop853_prepare,
    .interpolate = dop853_interpolate,
};
