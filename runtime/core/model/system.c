/* Sizes of a system's motions. */
#include "model/system.h"

#include <math.h>

double fastest(const struct system *s, const double *x)
{
    double found = 0.0;
    for (int i = 0; i < s->n; i++) {
        const double entry = fabs(x[i]) / s->unit[i];
        if (!(entry <= found)) /* a NaN too */
            found = isnan(entry) ? INFINITY : entry;
    }
    return found;
}
