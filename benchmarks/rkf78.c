/* Flight by accelerations that CasADi wrote: Runge-Kutta-Fehlberg 7(8) with step control, timed from C.
 *
 * E. Fehlberg, NASA TR R-287, 1968; step control as usual: 0.9 error^(-1/8), between 0.2 and 5 times. Built by flight.py.
 */
#define _POSIX_C_SOURCE 199309L
#include <math.h>
#include <string.h>
#include <time.h>

enum { STAGES = 13, MOST = 400 };

typedef int casadi_function(const double **arguments, double **results, long long *iw, double *w, int memory);

static const double A[STAGES][STAGES - 1] = {
    {0},
    {2.0 / 27},
    {1.0 / 36, 1.0 / 12},
    {1.0 / 24, 0, 1.0 / 8},
    {5.0 / 12, 0, -25.0 / 16, 25.0 / 16},
    {1.0 / 20, 0, 0, 1.0 / 4, 1.0 / 5},
    {-25.0 / 108, 0, 0, 125.0 / 108, -65.0 / 27, 125.0 / 54},
    {31.0 / 300, 0, 0, 0, 61.0 / 225, -2.0 / 9, 13.0 / 900},
    {2, 0, 0, -53.0 / 6, 704.0 / 45, -107.0 / 9, 67.0 / 90, 3},
    {-91.0 / 108, 0, 0, 23.0 / 108, -976.0 / 135, 311.0 / 54, -19.0 / 60, 17.0 / 6, -1.0 / 12},
    {2383.0 / 4100, 0, 0, -341.0 / 164, 4496.0 / 1025, -301.0 / 82, 2133.0 / 4100, 45.0 / 82, 45.0 / 164, 18.0 / 41},
    {3.0 / 205, 0, 0, 0, 0, -6.0 / 41, -3.0 / 205, -3.0 / 41, 3.0 / 41, 6.0 / 41, 0},
    {-1777.0 / 4100, 0, 0, -341.0 / 164, 4496.0 / 1025, -289.0 / 82, 2193.0 / 4100, 51.0 / 82, 33.0 / 164, 12.0 / 41, 0, 1}};
static const double B[STAGES] = {0, 0, 0, 0, 0, 34.0 / 105, 9.0 / 35, 9.0 / 35, 9.0 / 280, 9.0 / 280, 0, 41.0 / 840, 41.0 / 840};

static void derivative(casadi_function *accelerate, int n, const double *y, double *dy)
{
    const double *arguments[] = {y, y + n};
    double *results[] = {dy + n};
    memcpy(dy, y + n, (size_t)n * sizeof *dy);
    accelerate(arguments, results, 0, 0, 0);
}

/* From y[2 n] at 0 to `until` with relative and absolute tolerance `tol`; returns how many evaluations that took. */
static long fly(casadi_function *accelerate, int n, double until, double tol, double *y)
{
    double k[STAGES][MOST], at[MOST];
    const int size = 2 * n;
    long evaluations = 0;
    double t = 0.0, h = 1e-2;
    while (t < until) {
        if (t + h > until)
            h = until - t;
        for (int s = 0; s < STAGES; s++) {
            memcpy(at, y, (size_t)size * sizeof *at);
            for (int j = 0; j < s; j++)
                if (A[s][j] != 0.0)
                    for (int i = 0; i < size; i++)
                        at[i] += h * A[s][j] * k[j][i];
            derivative(accelerate, n, at, k[s]);
        }
        evaluations += STAGES;
        double error = 0.0;
        for (int i = 0; i < size; i++) {
            const double miss = h * 41.0 / 840.0 * (k[0][i] + k[10][i] - k[11][i] - k[12][i]);
            error = fmax(error, fabs(miss) / (tol + tol * (fabs(y[i]) + h * fabs(k[0][i]))));
        }
        if (error <= 1.0) {
            t = t + h >= until ? until : t + h;
            for (int s = 5; s < STAGES; s++)
                if (B[s] != 0.0)
                    for (int i = 0; i < size; i++)
                        y[i] += h * B[s] * k[s][i];
        }
        h *= fmin(fmax(0.9 * pow(fmax(error, 1e-10), -0.125), 0.2), error <= 1.0 ? 5.0 : 1.0);
    }
    return evaluations;
}

/* The fastest of `rounds` flights in seconds; y[2 n] becomes the end. */
double rkf78(casadi_function *accelerate, int n, double until, double tol, int rounds, double *y, long *evaluations)
{
    double start[MOST], best = INFINITY;
    memcpy(start, y, 2 * (size_t)n * sizeof *y);
    for (int i = 0; i < rounds; i++) {
        struct timespec a, b;
        memcpy(y, start, 2 * (size_t)n * sizeof *y);
        clock_gettime(CLOCK_MONOTONIC, &a);
        *evaluations = fly(accelerate, n, until, tol, y);
        clock_gettime(CLOCK_MONOTONIC, &b);
        best = fmin(best, (double)(b.tv_sec - a.tv_sec) + 1e-9 * (double)(b.tv_nsec - a.tv_nsec));
    }
    return best;
}
