/* Rows of the closure, of driven joints and of held contacts, so that how near they are to dependence is the same in all units of length. */
#include "constraints/rows.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "constraints/active_set.h"

/* In units of the coordinates, so that how near rows are is the same in all units of length; their lengths */
static void scale_to_units(const struct system *s, size_t rows, double *g, double *length)
{
    const size_t n = s->n;
    for (size_t j = 0; j < rows; j++) {
        double sum = 0.0;
        for (size_t i = 0; i < n; i++) {
            g[j * n + i] *= s->unit[i];
            sum += g[j * n + i] * g[j * n + i];
        }
        length[j] = sqrt(sum);
    }
}

static void divide_by_lengths(size_t n, size_t rows, const double *length, double *g)
{
    for (size_t j = 0; j < rows; j++)
        for (size_t i = 0; i < n; i++)
            g[j * n + i] /= length[j];
}

void scaled_closure_rows(const struct system *s, const double *q, double *g, double *length)
{
    const struct ccgen_model *m = s->model;
    const size_t closed = m->rows;
    if (closed)
        m->closure_jacobian(s->k, q, g); /* rows of A are the columns of A^T */
    scale_to_units(s, closed, g, length);
    for (size_t j = 0; j < closed; j++) { /* both rows of a pin by the longer, one alone by at least the size of the
                                           * mechanism: a row that vanishes must be seen */
        const size_t other = m->partner[j];
        if (other == j)
            length[j] = fmax(length[j], s->length);
        else if (other > j)
            length[j] = length[other] = fmax(fmax(length[j], length[other]), DBL_MIN);
    }
    divide_by_lengths(s->n, closed, length, g);
}

void keep_rows_on(const struct system *s, double *g)
{
    const size_t n = s->n;
    for (size_t k = 0; k < (size_t)s->rows_on; k++)
        if ((size_t)s->on[k] != k)
            memcpy(g + k * n, g + s->on[k] * n, n * sizeof *g);
}

void spread_multipliers(const struct system *s, const double *of_rows_on, double *lambda)
{
    memset(lambda, 0, s->model->rows * sizeof *lambda);
    for (int k = 0; k < s->rows_on; k++)
        lambda[s->on[k]] = of_rows_on[k];
}

void scaled_other_rows(struct system *s, const double *q, int held, const double *y, const double *t, double *push,
                       double *g, double *length, double *right)
{
    const struct ccgen_model *m = s->model;
    const size_t n = s->n, drives = m->drives, rows = drives + held;
    memset(g, 0, drives * n * sizeof *g);
    memset(right, 0, drives * sizeof *right);
    for (size_t d = 0; d < drives; d++) {
        g[d * n + m->driven[2 * d]] = 1.0;
        if (m->driven[2 * d + 1] >= 0)
            g[d * n + m->driven[2 * d + 1]] = -1.0;
    }
    if (drives && t)
        m->prescribed(s->k, *t, s->inputs, right);
    for (int j = 0; j < held; j++)
        active_row(s, q, j, push, g + (drives + j) * n);
    memcpy(right + drives, y, held * sizeof *right);
    scale_to_units(s, rows, g, length);
    for (size_t j = drives; j < rows; j++)
        length[j] = fmax(length[j], DBL_MIN);
    divide_by_lengths(n, rows, length, g);
}

double driven_by(const struct ccgen_model *m, int d, const double *x)
{
    const int second = m->driven[2 * d + 1];
    return x[m->driven[2 * d]] - (second < 0 ? 0.0 : x[second]);
}
