/* The complementarity problem of simultaneous impacts: 0 <= P, 0 <= z = W P + b, P.z = 0.
 *
 * For symmetric positive semidefinite W it is the optimality condition of: minimise P.W P / 2 + b.P over P >= 0. The
 * active-set method of C. L. Lawson and R. J. Hanson (Solving Least Squares Problems, 1974, chapter 23) solves it in
 * finitely many steps. All contacts pushing is tried first: it is the usual case and keeps symmetric impacts symmetric.
 */
#include "core.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

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
        if (a[j * n + j] <= 1e-11 * largest)
            continue;
        double c = 0.0;
        for (int i = 0; i < n; i++)
            c += v[i * n + j] * r[i];
        c /= a[j * n + j];
        for (int i = 0; i < n; i++)
            x[i] += c * v[i * n + j];
    }
}

/* Solve W x = -b over the members of the active set: Cholesky, or least norm where rows are dependent. */
static void solve_active(int n, const double *W, const double *b, const char *active, double *work, int *index, double *x)
{
    int m = 0;
    double *a = work, *v = work + (size_t)n * n, *r = v + (size_t)n * n, *y = r + n;
    for (int i = 0; i < n; i++)
        if (active[i])
            index[m++] = i;
    memset(x, 0, n * sizeof *x);
    for (int i = 0; i < m; i++) {
        r[i] = y[i] = -b[index[i]];
        for (int j = 0; j < m; j++)
            a[i * m + j] = W[(size_t)index[i] * n + index[j]];
    }
    for (int j = 0; j < m; j++) {
        double d = a[j * m + j];
        for (int k = 0; k < j; k++)
            d -= a[j * m + k] * a[j * m + k];
        if (!(d > 1e-11 * W[(size_t)index[j] * n + index[j]])) {
            for (int i = 0; i < m; i++)
                for (int k = 0; k < m; k++)
                    a[i * m + k] = W[(size_t)index[i] * n + index[k]];
            least_norm(m, a, v, r, y);
            goto spread;
        }
        a[j * m + j] = sqrt(d);
        for (int i = j + 1; i < m; i++) {
            double s = a[i * m + j];
            for (int k = 0; k < j; k++)
                s -= a[i * m + k] * a[j * m + k];
            a[i * m + j] = s / a[j * m + j];
        }
    }
    for (int i = 0; i < m; i++) {
        for (int k = 0; k < i; k++)
            y[i] -= a[i * m + k] * y[k];
        y[i] /= a[i * m + i];
    }
    for (int i = m - 1; i >= 0; i--) {
        for (int k = i + 1; k < m; k++)
            y[i] -= a[k * m + i] * y[k];
        y[i] /= a[i * m + i];
    }
spread:
    for (int i = 0; i < m; i++)
        x[index[i]] = y[i];
}

static double residual(int n, const double *W, const double *b, const double *P, int i)
{
    double z = b[i];
    for (int j = 0; j < n; j++)
        z += W[(size_t)i * n + j] * P[j];
    return z;
}

int solve_complementarity(int n, const double *W, const double *b, double *P)
{
    if (n <= 0)
        return 0;
    double *work = malloc(((size_t)2 * n * n + 3 * (size_t)n) * sizeof *work);
    int *index = malloc((size_t)n * sizeof *index);
    char *active = malloc((size_t)n);
    int failed = 1;
    if (!work || !index || !active)
        goto end;
    double *x = work + 2 * (size_t)n * n + 2 * (size_t)n;
    double scale = 0.0;
    for (int i = 0; i < n; i++)
        scale = fmax(scale, fabs(b[i]));
    const double small = 1e-13 * scale;

    memset(active, 1, (size_t)n);
    solve_active(n, W, b, active, work, index, P);
    failed = 0;
    for (int i = 0; i < n; i++)
        failed |= P[i] < 0.0 || fabs(residual(n, W, b, P, i)) > 1e-10 * scale;
    if (!failed)
        goto end;

    memset(active, 0, (size_t)n);
    memset(P, 0, n * sizeof *P);
    for (int step = 0; step < 10 * (n + 1); step++) {
        int enter = -1;
        double worst = -small;
        for (int i = 0; i < n; i++) {
            const double z = active[i] ? 0.0 : residual(n, W, b, P, i);
            if (z < worst) {
                worst = z;
                enter = i;
            }
        }
        if (enter < 0) {
            failed = 0;
            goto end;
        }
        active[enter] = 1;
        for (;;) {
            solve_active(n, W, b, active, work, index, x);
            double part = 1.0;
            int leave = -1;
            for (int i = 0; i < n; i++)
                if (active[i] && x[i] <= 0.0 && P[i] < part * (P[i] - x[i])) {
                    part = P[i] / (P[i] - x[i]);
                    leave = i;
                }
            for (int i = 0; i < n; i++)
                P[i] += part * (x[i] - P[i]);
            if (leave < 0)
                break;
            active[leave] = 0;
            P[leave] = 0.0;
        }
    }
end:
    free(active);
    free(index);
    free(work);
    return failed;
}
