/* The system's derivative. */
#include "core.h"

#include <math.h>
#include <string.h>

enum outcome system_derivative(struct system *s, double t, const double *y, double *dy)
{
    const int n = s->n;
    s->evaluations++;
    memcpy(dy, y + n, n * sizeof *dy);
    if (s->model->acceleration(s->k, y, y + n, t, NULL, dy + n, s->multipliers))
        return OUTCOME_LOST_RANK;
    for (int i = 0; i < n; i++)
        if (!isfinite(dy[n + i]))
            return OUTCOME_NOT_FINITE;
    return OUTCOME_DONE;
}
