/* Inverses of small matrices that are surely regular, column by column. The condition is that of Frobenius' norms, which is at most n
 * times that of the largest and the least singular value, and never less. */
#include "algebra/inverse.h"

#include <math.h>
#include <string.h>

#include "algebra/elimination.h"
#include "base/tolerances.h"

int invert_sure(int n, const double *W, double sure, double *inverse, double *scratch)
{
    double *even = scratch, *copy = even + n * n, *scale = copy + n * n, *x = scale + n;
    double least = INFINITY, most = 0.0, size = 0.0, of_inverse = 0.0;
    for (int i = 0; i < n; i++) {
        scale[i] = sqrt(fabs(W[i * n + i]));
        least = fmin(least, scale[i]);
        most = fmax(most, scale[i]);
    }
    if (n && !(least > sure * most && isfinite(most)))
        return 0;
    for (int i = 0; i < n * n; i++) {
        even[i] = W[i] / (scale[i / n] * scale[i % n]);
        size += even[i] * even[i];
    }
    for (int j = 0; j < n; j++) {
        memcpy(copy, even, (size_t)n * n * sizeof *even);
        memset(x, 0, n * sizeof *x);
        x[j] = 1.0;
        if (!eliminate(n, copy, x, DEPENDENT_PIVOT))
            return 0;
        for (int i = 0; i < n; i++) {
            of_inverse += x[i] * x[i];
            inverse[i * n + j] = x[i] / (scale[i] * scale[j]);
        }
    }
    return !n || size * of_inverse * sure * sure < 1.0;
}
