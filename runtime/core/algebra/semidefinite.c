/* Symmetric positive semidefinite systems: Cholesky's factor where all pivots keep their digits, else eigenvalues, whose small ones
 * are left out. */
#include "algebra/semidefinite.h"

#include <math.h>
#include <string.h>

#include "algebra/cholesky.h"
#include "base/tolerances.h"

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
        if (a[j * n + j] <= DEPENDENT_PIVOT * largest)
            continue;
        double c = 0.0;
        for (int i = 0; i < n; i++)
            c += v[i * n + j] * r[i];
        c /= a[j * n + j];
        for (int i = 0; i < n; i++)
            x[i] += c * v[i * n + j];
    }
}

size_t semidefinite_scratch(int n)
{
    return 2 * (size_t)n * n;
}

void solve_semidefinite(int n, const double *W, const double *r, double *x, double *scratch)
{
    double *a = scratch, *v = a + (size_t)n * n;
    if (cholesky(n, W, n, NULL, DEPENDENT_PIVOT, a)) {
        memcpy(a, W, (size_t)n * n * sizeof *a);
        least_norm(n, a, v, r, x);
        return;
    }
    memcpy(x, r, (size_t)n * sizeof *x);
    cholesky_solve(n, a, x);
}

int solve_definite_well(int n, const double *W, double *x, double *scratch)
{
    if (cholesky(n, W, n, NULL, WELL_PIVOT, scratch))
        return 1;
    cholesky_solve(n, scratch, x);
    return 0;
}
