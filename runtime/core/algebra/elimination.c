/* Gaussian elimination with exchange of rows, those compared by what is left of them (G. H. Golub, C. F. Van Loan, Matrix
 * Computations, 4th edition, 2013, section 3.4). */
#include "algebra/elimination.h"

#include <math.h>

static double largest(int n, const double *row)
{
    double found = 0.0;
    for (int j = 0; j < n; j++) /* no call of a library for each, as fmax may be */
        found = fabs(row[j]) > found ? fabs(row[j]) : found;
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
        const double *pivot = a + k * n;
        for (int i = k + 1; i < n; i++) {
            double *row = a + i * n;
            const double factor = row[k] / pivot[k];
            for (int j = k; j < n; j++)
                row[j] -= factor * pivot[j];
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

int eliminate_dependent(int rows, int n, double *a, double *x, int *order, double least)
{
    int rank = 0;
    for (int i = 0; i < rows; i++) {
        const double size = largest(n, a + i * n);
        for (int j = 0; j < n && size > 0.0; j++)
            a[i * n + j] /= size;
        x[i] /= size > 0.0 ? size : 1.0;
    }
    for (int j = 0; j < n; j++)
        order[j] = j;
    for (; rank < n && rank < rows; rank++) {
        int row = rank, column = rank;
        for (int i = rank; i < rows; i++)
            for (int j = rank; j < n; j++)
                if (fabs(a[i * n + j]) > fabs(a[row * n + column])) {
                    row = i;
                    column = j;
                }
        if (!(fabs(a[row * n + column]) > least))
            break;
        if (row != rank)
            exchange(n, a + rank * n, a + row * n, x + rank, x + row);
        const int swap = order[rank];
        order[rank] = order[column];
        order[column] = swap;
        for (int i = 0; i < rows; i++) {
            const double number = a[i * n + rank];
            a[i * n + rank] = a[i * n + column];
            a[i * n + column] = number;
        }
        for (int i = rank + 1; i < rows; i++) {
            const double factor = a[i * n + rank] / a[rank * n + rank];
            for (int j = rank; j < n; j++)
                a[i * n + j] -= factor * a[rank * n + j];
            x[i] -= factor * x[rank];
        }
    }
    for (int k = rank - 1; k >= 0; k--) {
        for (int j = k + 1; j < rank; j++)
            x[k] -= a[k * n + j] * x[j];
        x[k] /= a[k * n + k];
    }
    return rank;
}
