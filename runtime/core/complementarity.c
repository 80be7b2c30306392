/* The complementarity problem of simultaneous impacts: 0 <= P, 0 <= z = W P + b, P.z = 0.
 *
 * For symmetric positive semidefinite W it is the optimality condition of: minimise P.W P / 2 + b.P over P >= 0. An
 * active-set method solves it in finitely many steps (J. Nocedal, S. J. Wright, Numerical Optimization, 2nd edition, 2006,
 * section 16.5): the contacts that push are kept independent, also where more contacts touch than the mechanism has
 * freedoms. All contacts pushing is tried first: it is the usual case and keeps symmetric impacts symmetric.
 */
#include "core.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double DEPENDENT = CCGEN_LIMIT(1e-11, 1e-5); /* a pivot below this fraction of its diagonal entry has lost its digits */
static const double WELL = CCGEN_LIMIT(1e-6, 1e-3);       /* likewise, has lost no more digits than can be spared */
enum { STEPS = 10 };                   /* per contact; far more than ever needed */

/* Eigenvalues of symmetric a[n][n] on its diagonal and eigenvectors in the columns of v, by cyclic Jacobi rotations. */
static void eigen(int n, double *a, double *v)
{
    memset(v, 0, (size_t)n * n * sizeof *v);
    for (int i = 0; i < n; i++)
        v[i * n + i] = 1.0;
    for (int sweep = 0; sweep < 60; sweep++) {
        double off = 0.0, all = 0.0;
        for (int i = 0; i < n; i++)
            for (int j = 0; j < n; j++) {
                all += a[i * n + j] * a[i * n + j];
                off += i == j ? 0.0 : a[i * n + j] * a[i * n + j];
            }
        if (off <= 1e-32 * all)
            return;
        for (int p = 0; p < n; p++)
            for (int q = p + 1; q < n; q++) {
                if (a[p * n + q] == 0.0)
                    continue;
                const double theta = 0.5 * (a[q * n + q] - a[p * n + p]) / a[p * n + q];
                const double t = copysign(1.0, theta) / (fabs(theta) + sqrt(theta * theta + 1.0));
                const double c = 1.0 / sqrt(t * t + 1.0), s = t * c;
                for (int i = 0; i < n; i++) {
                    const double x = a[i * n + p], y = a[i * n + q];
                    a[i * n + p] = c * x - s * y;
                    a[i * n + q] = s * x + c * y;
                }
                for (int i = 0; i < n; i++) {
                    const double x = a[p * n + i], y = a[q * n + i];
                    a[p * n + i] = c * x - s * y;
                    a[q * n + i] = s * x + c * y;
                    const double g = v[i * n + p], h = v[i * n + q];
                    v[i * n + p] = c * g - s * h;
                    v[i * n + q] = s * g + c * h;
                }
            }
    }
}

/* x of least norm with a x = r for symmetric positive semidefinite a[n][n]; a is destroyed, v[n][n] is scratch. */
static void least_norm(int n, double *a, double *v, const double *r, double *x)
{
    double largest = 0.0;
    eigen(n, a, v);
    for (int i = 0; i < n; i++)
        largest = fmax(largest, a[i * n + i]);
    memset(x, 0, n * sizeof *x);
    for (int j = 0; j < n; j++) {
        if (a[j * n + j] <= DEPENDENT * largest)
            continue;
        double c = 0.0;
        for (int i = 0; i < n; i++)
            c += v[i * n + j] * r[i];
        c /= a[j * n + j];
        for (int i = 0; i < n; i++)
            x[i] += c * v[i * n + j];
    }
}

/* Cholesky factor of W over the indices set[m] (all where it is NULL), in a[m][m]; 0, or 1 where one is nearer to the others
 * than the share `dependent` of its own compliance. */
static int factorise(int n, const double *W, int m, const int *set, double dependent, double *a)
{
    for (int j = 0; j < m; j++)
        for (int i = j; i < m; i++) {
            const size_t row = set ? set[i] : i, column = set ? set[j] : j;
            double sum = W[row * n + column];
            for (int k = 0; k < j; k++)
                sum -= a[i * m + k] * a[j * m + k];
            if (i == j && !(sum > dependent * W[column * n + column]))
                return 1;
            a[i * m + j] = i == j ? sqrt(sum) : sum / a[j * m + j];
        }
    return 0;
}

/* x = (a a^T)^-1 x for the factor a[m][m] */
static void substitute(int m, const double *a, double *x)
{
    for (int i = 0; i < m; i++) {
        for (int k = 0; k < i; k++)
            x[i] -= a[i * m + k] * x[k];
        x[i] /= a[i * m + i];
    }
    for (int i = m - 1; i >= 0; i--) {
        for (int k = i + 1; k < m; k++)
            x[i] -= a[k * m + i] * x[k];
        x[i] /= a[i * m + i];
    }
}

static double residual(int n, const double *W, const double *b, const double *P, int i)
{
    double z = b[i];
    for (int j = 0; j < n; j++)
        z += W[(size_t)i * n + j] * P[j];
    return z;
}

size_t semidefinite_scratch(int n)
{
    return 2 * (size_t)n * n;
}

void solve_semidefinite(int n, const double *W, const double *r, double *x, double *scratch)
{
    double *a = scratch, *v = a + (size_t)n * n;
    if (factorise(n, W, n, NULL, DEPENDENT, a)) {
        memcpy(a, W, (size_t)n * n * sizeof *a);
        least_norm(n, a, v, r, x);
        return;
    }
    memcpy(x, r, (size_t)n * sizeof *x);
    substitute(n, a, x);
}

int solve_definite_well(int n, const double *W, double *x, double *scratch)
{
    if (factorise(n, W, n, NULL, WELL, scratch))
        return 1;
    substitute(n, scratch, x);
    return 0;
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
        if (factorise(n, W, m, set, DEPENDENT, a))
            return -1;
        for (int i = 0; i < m; i++)
            d[i] = -W[(size_t)set[i] * n + enter];
        substitute(m, a, d);
        double curvature = W[(size_t)enter * n + enter], part = INFINITY;
        int leave = -1;
        for (int i = 0; i < m; i++) {
            curvature += W[(size_t)enter * n + set[i]] * d[i];
            if (d[i] < 0.0 && P[set[i]] < -part * d[i]) {
                part = -P[set[i]] / d[i];
                leave = i;
            }
        }
        const int independent = curvature > DEPENDENT * W[(size_t)enter * n + enter];
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
