/* Dormand-Prince 5(4): explicit Runge-Kutta of order 5 with an error estimate of order 4 and dense output of order 4, for rough
 * forces and low accuracy (E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, 1993, sections
 * II.5 and II.6; L. F. Shampine's interpolant). */
#include "methods/method.h"

#include <math.h>
#include <string.h>

#include "motion/derivative.h"

enum { STAGES = 7, DEGREE = 4 };

static const double C[STAGES] = {0.0, 0.2L, 0.3L, 0.8L, 8.0L / 9.0L, 1.0, 1.0};

/* The last row is the solution of order 5, too. */
static const double A[STAGES][STAGES] = {
    {0.0},
    {0.2L},
    {3.0L / 40.0L, 9.0L / 40.0L},
    {44.0L / 45.0L, -56.0L / 15.0L, 32.0L / 9.0L},
    {19372.0L / 6561.0L, -25360.0L / 2187.0L, 64448.0L / 6561.0L, -212.0L / 729.0L},
    {9017.0L / 3168.0L, -355.0L / 33.0L, 46732.0L / 5247.0L, 49.0L / 176.0L, -5103.0L / 18656.0L},
    {35.0L / 384.0L, 0.0, 500.0L / 1113.0L, 125.0L / 192.0L, -2187.0L / 6784.0L, 11.0L / 84.0L}};

/* solution of order 5 less that of order 4 */
static const double E[STAGES] = {71.0L / 57600.0L,      0.0,          -71.0L / 16695.0L, 71.0L / 1920.0L,
                                 -17253.0L / 339200.0L, 22.0L / 525.0L, -1.0L / 40.0L};

/* last coefficient of the interpolant */
static const double D[STAGES] = {-12715105075.0L / 11282082432.0L,  0.0,
                                 87487479700.0L / 32700410799.0L,   -10690763975.0L / 1880347072.0L,
                                 701980252875.0L / 199316789632.0L, -1453857185.0L / 822651844.0L,
                                 69997945.0L / 29380423.0L};

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

static double dopri5_measure(const double *scratch, int size, struct tolerance tolerance, const double *y, const double *y1)
{
    const double *estimate = scratch + (size_t)ESTIMATE * size;
    double sum = 0.0;
    for (int k = 0; k < size; k++) {
        const double scale = tolerance.atol + tolerance.rtol * fmax(fabs(y[k]), fabs(y1[k]));
        sum += (estimate[k] / scale) * (estimate[k] / scale);
    }
    return sqrt(sum / size);
}

static enum outcome dopri5_prepare(struct system *s, double *scratch, double t, double h, const double *y, const double *dy,
                                   const double *y1, const double *dy1)
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
        y[k] = start[k] +
               theta * (c[k] + rest * (c[size + k] + theta * (c[2 * size + k] + rest * c[3 * size + k])));
}

const struct method dopri5 = {"dopri5", 5, 1, dopri5_scratch, NULL, dopri5_step, dopri5_estimates, dopri5_measure,
                              dopri5_prepare, dopri5_interpolate};
