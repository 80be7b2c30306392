/* Cholesky's factorisation without square roots; see cholesky.h. */
#include "algebra/cholesky.h"

int cholesky(int n, const double *W, int m, const int *set, double dependent, double *a)
{
    for (int j = 0; j < m; j++)
        for (int i = j; i < m; i++) {
            const size_t row = set ? set[i] : i, column = set ? set[j] : j;
            double sum = W[row * n + column];
            for (int k = 0; k < j; k++)
                sum -= a[i * m + k] * a[j * m + k] * a[k * m + k];
            if (i == j && !(sum > dependent * W[column * n + column]))
                return 1;
            a[i * m + j] = i == j ? sum : sum / a[j * m + j];
        }
    return 0;
}

void cholesky_solve(int m, const double *a, double *x)
{
    for (int i = 0; i < m; i++)
        for (int k = 0; k < i; k++)
            x[i] -= a[i * m + k] * x[k];
    for (int i = m - 1; i >= 0; i--) {
        x[i] /= a[i * m + i];
        for (int k = i + 1; k < m; k++)
            x[i] -= a[k * m + i] * x[k];
    }
}
