/* Dormand-Prince 5(4): explicit Runge-Kutta of order 5 with an error estimate of order 4 and dense output of order 4, for rough
 * forces and low accuracy (E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, 1993, sections
 * II.5 and II.6; L. F. Shampine's interpolant). */
#include "methods/method.h"

#include <math.h>
#include <string.h>

#include "methods/dopri5_tableau.h"
#include "motion/derivative.h"

enum { DEGREE = 4 };

/* scratch: STAGES derivatives, a state, the estimate, the start and DEGREE coefficients of the interpolant */
static double *part(double *scratch, int size, int i)
{
    return scratch + (size_t)i * size;
}

enum { AT = STAGES, ESTIMATE, START, COEFFICIENTS, PARTS = COEFFICIENTS + DEGREE };

static size_t dopri5_scratch(const struct system *s)
{
    return (size_t)PARTS * s->size;
}

static enum outcome dopri5_step(struct system *s, double *scratch, double t, double h, struct tolerance tolerance,
                                const double *y, const double *dy, double *y1)
{
    const int size = s->size;
    (void)tolerance;
    memcpy(scratch, dy, size * sizeof *dy);
    for (int i = 1; i < STAGES; i++) {
        double *at = i == STAGES - 1 ? y1 : part(scratch, size, AT);
        for (int k = 0; k < size; k++) {
            double sum = 0.0;
            for (int j = 0; j < i; j++)
                sum += A[i][j] * scratch[(size_t)j * size + k];
            at[k] = y[k] + h * sum;
        }
        const enum outcome outcome = system_derivative(s, t + C[i] * h, at, part(scratch, size, i));
        if (outcome)
            return outcome;
    }
    double *estimate = part(scratch, size, ESTIMATE);
    for (int k = 0; k < size; k++) {
        double sum = 0.0;
        for (int j = 0; j < STAGES; j++)
            sum += E[j] * scratch[(size_t)j * size + k];
        estimate[k] = h * sum;
    }
    return OUTCOME_DONE;
}

static double *dopri5_estimates(double *scratch, int size, int *count)
{
    *count = 1;
    return part(scratch, size, ESTIMATE);
}

static double dopri5_measure(const double *scratch, int size, struct tolerance tolerance, const double *y,
                             const double *y1)
{
    const double *estimate = scratch + (size_t)ESTIMATE * size;
    double sum = 0.0;
    for (int k = 0; k < size; k++) {
        const double scale = allowed_error(tolerance, k, fmax(fabs(y[k]), fabs(y1[k])));
        sum += (estimate[k] / scale) * (estimate[k] / scale);
    }
    return sqrt(sum / size);
}

static enum outcome dopri5_prepare(struct system *s, double *scratch, double t, double h, const double *y,
                                   const double *dy, const double *y1, const double *dy1)
{
    const int size = s->size;
    double *c = part(scratch, size, COEFFICIENTS);
    (void)t;
    memcpy(part(scratch, size, START), y, size * sizeof *y);
    for (int k = 0; k < size; k++) {
        double sum = 0.0;
        for (int j = 0; j < STAGES; j++)
            sum += D[j] * scratch[(size_t)j * size + k];
        const double difference = y1[k] - y[k], bend = h * dy[k] - difference;
        c[k] = difference;
        c[size + k] = bend;
        c[2 * size + k] = difference - h * dy1[k] - bend;
        c[3 * size + k] = h * sum;
    }
    return OUTCOME_DONE;
}

static void dopri5_interpolate(const double *scratch, int size, double theta, double *y)
{
    const double *start = scratch + (size_t)START * size, *c = scratch + (size_t)COEFFICIENTS * size;
    const double rest = 1.0 - theta;
    for (int k = 0; k < size; k++)
        y[k] = start[k] + theta * (c[k] + rest * (c[size + k] + theta * (c[2 * size + k] + rest * c[3 * size + k])));
}

const struct method dopri5 = {
    .name = "dopri5",
    .order = 5,
    .derivatives = 1,
    .scratch = dopri5_scratch,
    .step = dopri5_step,
    .estimates = dopri5_estimates,
    .measure = dopri5_measure,
    .prepare = dopri5_prepare,
    .interpolate = dopri5_interpolate,
};
