/* The complementarity problem of simultaneous impacts: 0 <= P, 0 <= z = W P + b, P.z = 0.
 *
 * For symmetric positive semidefinite W it is the optimality condition of: minimise P.W P / 2 + b.P over P >= 0. An
 * active-set method solves it in finitely many steps (J. Nocedal, S. J. Wright, Numerical Optimization, 2nd edition, 2006,
 * section 16.5): the contacts that push are kept independent, also where more contacts touch than the mechanism has
 * freedoms. All contacts pushing is tried first: it is the usual case and keeps symmetric impacts symmetric.
 */
#include "complementarity/complementarity.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "algebra/cholesky.h"
#include "algebra/semidefinite.h"

enum { STEPS = 10 }; /* per contact; far more than ever needed */

static double residual(int n, const double *W, const double *b, const double *P, int i)
{
    double z = b[i];
    for (int j = 0; j < n; j++)
        z += W[(size_t)i * n + j] * P[j];
    return z;
}

/* All contacts pushing: P = -W^-1 b, of least norm where rows are dependent. 0 if it is a solution. */
static int all_push(int n, const double *W, const double *b, double scale, double *scratch, double *r, double *P)
{
    for (int i = 0; i < n; i++)
        r[i] = -b[i];
    solve_semidefinite(n, W, r, P, scratch);
    int wrong = 0;
    for (int i = 0; i < n; i++)
        wrong |= P[i] < 0.0 || fabs(residual(n, W, b, P, i)) > CCGEN_LIMIT(1e-10, 1e-4) * scale;
    return wrong;
}

/* Let contact `enter` push, while z stays 0 on the set[m] of contacts that push: move along the direction that keeps it so
 * until z of `enter` vanishes, dropping contacts whose impulse reaches 0 on the way. Returns the new m, or -1. */
static int admit(int n, const double *W, int m, int *set, int enter, double z, double *a, double *d, double *P)
{
    for (;;) {
        if (cholesky(n, W, m, set, DEPENDENT_PIVOT, a))
            return -1;
        for (int i = 0; i < m; i++)
            d[i] = -W[(size_t)set[i] * n + enter];
        cholesky_solve(m, a, d);
        double curvature = W[(size_t)enter * n + enter], part = INFINITY;
        int leave = -1;
        for (int i = 0; i < m; i++) {
            curvature += W[(size_t)enter * n + set[i]] * d[i];
            if (d[i] < 0.0 && P[set[i]] < -part * d[i]) {
                part = -P[set[i]] / d[i];
                leave = i;
            }
        }
        const int independent = curvature > DEPENDENT_PIVOT * W[(size_t)enter * n + enter];
        if (independent && -z <= part * curvature) {
            part = -z / curvature;
            leave = -1;
        }
        if (!isfinite(part))
            return -1;
        for (int i = 0; i < m; i++)
            P[set[i]] += part * d[i];
        P[enter] += part;
        z += part * curvature;
        if (leave < 0) {
            set[m] = enter;
            return m + 1;
        }
        P[set[leave]] = 0.0;
        set[leave] = set[--m];
    }
}

int solve_complementarity(int n, const double *W, const double *b, double *P)
{
    if (n <= 0)
        return 0;
    const size_t square = (size_t)n * n;
    double *work = malloc((2 * square + n) * sizeof *work);
    int *set = malloc((size_t)n * sizeof *set);
    int failed = 1;
    if (!work || !set)
        goto end;
    double scale = 0.0;
    for (int i = 0; i < n; i++)
        scale = fmax(scale, fabs(b[i]));
    if (!all_push(n, W, b, scale, work, work + 2 * square, P)) {
        failed = 0;
        goto end;
    }
    memset(P, 0, (size_t)n * sizeof *P);
    for (int step = 0, m = 0; step < STEPS * (n + 1) && m >= 0; step++) {
        int enter = -1;
        double worst = -CCGEN_LIMIT(1e-13, 1e-6) * scale;
        for (int i = 0; i < n; i++) {
            int pushes = 0;
            for (int j = 0; j < m; j++)
                pushes |= set[j] == i;
            const double z = pushes ? 0.0 : residual(n, W, b, P, i);
            if (z < worst) {
                worst = z;
                enter = i;
            }
        }
        if (enter < 0) {
            failed = 0;
            goto end;
        }
        m = admit(n, W, m, set, enter, worst, work, work + 2 * square, P);
    }
end:
    free(set);
    free(work);
    return failed;
}
