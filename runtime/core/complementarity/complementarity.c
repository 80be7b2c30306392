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
#include <string.h>

#include "algebra/cholesky.h"
#include "algebra/semidefinite.h"
#include "base/tolerances.h"

enum { STEPS = 10 }; /* per contact; far more than ever needed */

/* z of contact i; in *size the size of its terms, of which its rounding is a part */
static double residual(int n, const double *W, const double *b, const double *P, int i, double *size)
{
    double z = b[i];
    *size = fabs(b[i]);
    for (int j = 0; j < n; j++) {
        const double term = W[(size_t)i * n + j] * P[j];
        z += term;
        *size += fabs(term);
    }
    return z;
}

/* All contacts pushing: P = -W^-1 b, of least norm where rows are dependent. 0 if it is a solution. */
static int all_push(int n, const double *W, const double *b, double scale, struct semidefinite *room, double *r,
                    double *P)
{
    for (int i = 0; i < n; i++)
        r[i] = -b[i];
    solve_semidefinite(n, W, r, P, room);
    double size;
    int wrong = 0;
    for (int i = 0; i < n; i++)
        wrong |= P[i] < 0.0 || fabs(residual(n, W, b, P, i, &size)) > ALL_PUSH * scale;
    return wrong;
}

/* The terms of z of `enter`, and those of the z of set[m] that it depends on by d[m] */
static double rounding_of(int n, const double *W, const double *b, int m, const int *set, const double *d, int enter,
                          const double *P)
{
    double all, size;
    residual(n, W, b, P, enter, &all);
    for (int i = 0; i < m; i++) {
        residual(n, W, b, P, set[i], &size);
        all += fabs(d[i]) * size;
    }
    return all;
}

/* Let contact `enter` push, while z stays 0 on the set[m] of contacts that push: move along the direction that keeps it so
 * until z of `enter` vanishes, dropping contacts whose impulse reaches 0 on the way. Returns the new m; -1 where that cannot be; m
 * as it was where z of `enter` is the rounding of those that it depends on: with their z it is 0. */
static int admit(int n, const double *W, const double *b, int m, int *set, int enter, double z, double *a, double *d,
                 double *P)
{
    for (int first = 1;; first = 0) {
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
        if (!independent && first && -z <= TERM_ROUNDING * rounding_of(n, W, b, m, set, d, enter, P))
            return m;
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

int solve_complementarity(struct arena *arena, int n, const double *W, const double *b, double *P)
{
    if (n <= 0)
        return 0;
    const struct mark mark = arena->top;
    struct semidefinite room;
    take_semidefinite(arena, &room, n);
    double *r = TAKE(arena, double, n);
    double *a = TAKE(arena, double, ((size_t)n * n)), *d = TAKE(arena, double, n);
    int *set = TAKE(arena, int, n);
    char *settled = TAKE(arena, char, n); /* whose z is rounding as long as the others push as they do */
    int failed = 1;
    if (arena->ran_out)
        goto end;
    double scale = 0.0;
    for (int i = 0; i < n; i++)
        scale = fmax(scale, fabs(b[i]));
    if (!all_push(n, W, b, scale, &room, r, P)) {
        failed = 0;
        goto end;
    }
    memset(P, 0, (size_t)n * sizeof *P);
    memset(settled, 0, n);
    for (int step = 0, m = 0; step < STEPS * (n + 1) && m >= 0; step++) {
        int enter = -1;
        double worst = 0.0;
        for (int i = 0; i < n; i++) {
            int pushes = settled[i];
            for (int j = 0; j < m; j++)
                pushes |= set[j] == i;
            double size = 0.0;
            const double z = pushes ? 0.0 : residual(n, W, b, P, i, &size);
            if (z < fmin(worst, -fmax(APPROACHES * scale, TERM_ROUNDING * size))) {
                worst = z;
                enter = i;
            }
        }
        if (enter < 0) {
            failed = 0;
            goto end;
        }
        const int before = m;
        m = admit(n, W, b, m, set, enter, worst, a, d, P);
        if (m == before && P[enter] == 0.0)
            settled[enter] = 1;
        else
            memset(settled, 0, n);
    }
end:
    give_back(arena, mark);
    return failed;
}
