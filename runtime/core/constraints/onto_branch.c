/* States put onto a branch of the closure: in the chart as they are, but for what keeps driven joints where they are and held contacts closed. */
#include "constraints/onto_branch.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "algebra/dot.h"
#include "algebra/orthogonal.h"
#include "base/tolerances.h"
#include "constraints/active_set.h"
#include "constraints/chart.h"
#include "constraints/nullspace.h"
#include "constraints/rows.h"
#include "model/contacts.h"

enum { CORRECTIONS = 12 };
static const double FARTHEST = 0.5; /* the longest correction of a place for driven joints and held contacts */

/* What driven joints and held contacts miss at the last configuration, given[drives] being where the first are to be: miss[], by lengths of rows g[][n]; and the
 * way[freedom] that takes it away, the shortest */
static double find_correction(struct system *s, struct branch *b, const double *given, double *q, double *way)
{
    const struct ccgen_model *m = s->model;
    const int n = s->n, d = b->freedom, drives = m->drives, held = active_rows(s, 0), rows = drives + held;
    const struct mark mark = s->arena->top;
    double *g = TAKE(s->arena, double, (size_t)rows *n), *length = TAKE(s->arena, double, rows);
    double *miss = TAKE(s->arena, double, rows), *columns = TAKE(s->arena, double, (size_t)rows *d);
    double *diagonal = TAKE(s->arena, double, rows), *beta = TAKE(s->arena, double, rows);
    double *gaps = TAKE(s->arena, double, m->contacts), *push = TAKE_ZEROS(s->arena, double, m->contacts);
    double *right = TAKE(s->arena, double, rows), size = INFINITY;
    int *order = TAKE(s->arena, int, rows);
    if (s->arena->ran_out)
        goto end;
    for (int i = 0; i < n; i++)
        q[i] = b->last.q[i] * s->unit[i];
    for (int k = 0; k < drives; k++)
        miss[k] = driven_by(m, k, q) - given[k];
    if (held)
        contact_gaps(s, q, gaps);
    for (int k = 0; k < held; k++)
        miss[drives + k] = gaps[s->active->set[k]];
    scaled_other_rows(s, q, held, miss + drives, NULL, push, g, length, right);
    for (int k = 0; k < rows; k++) {
        order[k] = k;
        for (int i = 0; i < d; i++)
            columns[(size_t)k * d + i] = dot(n, g + (size_t)k * n, b->last.T + (size_t)i * n);
    }
    const int rank = reduce_columns(d, rows, columns, RANK_TOLERANCE_PROJECTED, diagonal, beta, order);
    memset(way, 0, d * sizeof *way);
    for (int k = 0; k < rank; k++)
        way[k] = -miss[order[k]] / length[order[k]];
    solve_transposed_triangle(d, rank, columns, diagonal, way);
    reflect(d, rank, columns, beta, 0, way);
    size = sqrt(dot(d, way, way));
end:
    give_back(s->arena, mark);
    return size;
}

/* Close q[n], which is interpolated, by the rows that are not about to be lost: what is left of their gaps is rounding. */
static enum outcome close_other_rows(struct system *s, double *q)
{
    const int n = s->n, rows = s->model->rows;
    const struct mark mark = s->arena->top;
    double *g = TAKE(s->arena, double, (size_t)rows *n), *length = TAKE(s->arena, double, rows);
    double *gap = TAKE(s->arena, double, rows), *diagonal = TAKE(s->arena, double, rows);
    double *beta = TAKE(s->arena, double, rows), *x = TAKE_ZEROS(s->arena, double, n);
    int *order = TAKE(s->arena, int, rows);
    const enum outcome outcome = s->arena->ran_out ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    if (outcome)
        goto end;
    s->model->closure(s->k, q, gap);
    scaled_closure_rows(s, q, g, length);
    keep_rows_on(s, g);
    for (int j = 0; j < s->rows_on; j++)
        order[j] = s->on[j];
    const int rank = reduce_columns(n, s->rows_on, g, BRIDGED, diagonal, beta, order);
    for (int k = 0; k < rank; k++)
        x[k] = -gap[order[k]] / length[order[k]];
    solve_transposed_triangle(n, rank, g, diagonal, x);
    reflect(n, rank, g, beta, 0, x);
    for (int i = 0; i < n; i++)
        q[i] += s->unit[i] * x[i];
end:
    give_back(s->arena, mark);
    return outcome;
}

/* The configuration along the branch, y[freedom] in the chart, at which driven joints are where they are given and held contacts are closed; way[freedom] is what is left of its
 * correction, x[n] is scratch. */
static enum outcome correct_place(struct system *s, struct branch *b, const double *given, double *y, double *way,
                                  double *x)
{
    double last = INFINITY;
    for (int pass = 0; pass < CORRECTIONS; pass++) {
        const double size = find_correction(s, b, given, x, way);
        if (!(size < FARTHEST))
            return OUTCOME_NOT_CLOSED;
        if (size <= 4.0 * DBL_EPSILON)
            return OUTCOME_DONE;
        if (size > 0.5 * last && size < sqrt(DBL_EPSILON)) { /* rounding, where driven joints all but stop the rest */
            memset(way, 0, b->freedom * sizeof *way);
            return OUTCOME_DONE;
        }
        last = size;
        for (int i = 0; i < b->freedom; i++)
            y[i] += way[i];
        const enum outcome outcome = lift_branch(s, b, y);
        if (outcome)
            return outcome;
    }
    return OUTCOME_NOT_CLOSED;
}

enum outcome put_onto_branch(struct system *s, double *q, double *u)
{
    struct branch *b = s->branch;
    const struct ccgen_model *m = s->model;
    const int n = s->n, d = b->freedom, others = m->drives + active_rows(s, 0);
    const struct mark mark = s->arena->top;
    double *y = TAKE(s->arena, double, d), *way = TAKE_ZEROS(s->arena, double, d),
           *given = TAKE(s->arena, double, m->drives);
    double *x = TAKE(s->arena, double, n);
    enum outcome outcome = s->arena->ran_out ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    if (outcome)
        goto end;
    if (b->known.margin < 0.0)
        copy_place(s, b, &b->begins, &b->known);
    for (int k = 0; k < m->drives; k++)
        given[k] = driven_by(m, k, q);
    for (int i = 0; i < d; i++) {
        y[i] = 0.0;
        for (int l = 0; l < n; l++)
            y[i] += b->chart[(size_t)i * n + l] * (q[l] / s->unit[l] - b->begins.q[l]);
    }
    outcome = lift_branch(s, b, y);
    outcome = outcome || !others ? outcome : correct_place(s, b, given, y, way, x);
    for (int i = 0; i < n && !outcome; i++) { /* the last correction is rounding, too short to bend */
        double there = b->last.q[i];
        for (int j = 0; j < d; j++)
            there += way[j] * b->last.T[(size_t)j * n + i];
        q[i] = there * s->unit[i];
    }
    if (!outcome && b->inside && !others) /* else driven joints and contacts are where they are to be */
        outcome = close_other_rows(s, q);
    memset(b->state, 0xff, 2 * (size_t)n * sizeof *b->state);
    if (!outcome)
        memcpy(b->state, q, n * sizeof *q);
    outcome = outcome ? outcome : keep_velocities_along_branch(s, q, u);
    if (!outcome)
        memcpy(b->state + n, u, n * sizeof *u);
end:
    give_back(s->arena, mark);
    return outcome;
}
