/* Gaussian elimination with exchange of rows, those compared by what is left of them (G. H. Golub, C. F. Van Loan, Matrix
 * Computations, 4th edition, 2013, section 3.4). */
#include "elimination.h"

#include <math.h>

static double largest(int n, const double *row)
{
    double found = 0.0;
    for (int j = 0; j < n; j++)
        found = fmax(found, fabs(row[j]));
    return found;
}

/* Rows a and b of n numbers, and their right-hand sides, change places. */
static void exchange(int n, double *a, double *b, double *of_a, double *of_b)
{
    double swap = *of_a;
    *of_a = *of_b;
    *of_b = swap;
    for (int j = 0; j < n; j++) {
        swap = a[j];
        a[j] = b[j];
        b[j] = swap;
    }
}

int eliminate(int n, double *a, double *x, double least)
{
    int sign = 1;
    for (int i = 0; i < n; i++) { /* rows of one size, so that pivots compare */
        const double size = largest(n, a + i * n);
        if (!(size > 0.0) || !isfinite(size))
            return 0;
        for (int j = 0; j < n; j++)
            a[i * n + j] /= size;
        x[i] /= size;
    }
    for (int k = 0; k < n; k++) {
        int best = k;
        for (int i = k + 1; i < n; i++)
            best = fabs(a[i * n + k]) > fabs(a[best * n + k]) ? i : best;
        if (!(fabs(a[best * n + k]) > least))
            return 0;
        if (best != k) {
            exchange(n, a + k * n, a + best * n, x + k, x + best);
            sign = -sign;
        }
        sign = a[k * n + k] < 0.0 ? -sign : sign;
        for (int i = k + 1; i < n; i++) {
            const double factor = a[i * n + k] / a[k * n + k];
            for (int j = k; j < n; j++)
                a[i * n + j] -= factor * a[k * n + j];
            x[i] -= factor * x[k];
        }
    }
    for (int k = n - 1; k >= 0; k--) {
        for (int j = k + 1; j < n; j++)
            x[k] -= a[k * n + j] * x[j];
        x[k] /= a[k * n + k];
    }
    return sign;
}
