/* The rows of a system that are on, and sizes of its motions. */
#include "model/system.h"

#include <math.h>

int find_rows_on(const struct ccgen_model *m, const double *parameters, int *on)
{
    int count = 0;
    for (int i = 0; i < m->rows; i++) {
        const int gate = m->row_held ? m->row_held[i] : -1;
        if (gate < 0 || parameters[gate] == 1.0)
            on[count++] = i;
    }
    return count;
}

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
