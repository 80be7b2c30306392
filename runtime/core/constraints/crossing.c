/* Rows that are about to be lost near a place of a branch, and a way across it (docs/theory, section 8).
 *
 * The way goes along the gradient of the signed distance from dependence, by differences of A between the vectors that are about to be lost, so that it crosses however the
 * motion lies: along the place, or at rest.
 */
#include "constraints/crossing.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "algebra/dot.h"
#include "algebra/orthogonal.h"
#include "base/tolerances.h"
#include "constraints/rows.h"

static const double WIDEST = 0.2;     /* rows that are farther from dependence are not about to be lost */
static const double ALIKE_LOST = 3.0; /* times as far as the nearest others are lost together with it */
static const double FLAT = 1e-3;      /* distance from dependence by the way along what does not cross */

/* v[n] without its parts along basis[count][n], which is orthonormal, made a unit vector; its length before that */
static double make_orthogonal(int n, int count, const double *basis, double *v)
{
    for (int pass = 0; pass < 2; pass++)
        for (int j = 0; j < count; j++) {
            const double part = dot(n, basis + (size_t)j * n, v);
            for (int i = 0; i < n; i++)
                v[i] -= part * basis[(size_t)j * n + i];
        }
    const double length = sqrt(dot(n, v, v));
    for (int i = 0; i < n && length > 0.0; i++)
        v[i] /= length;
    return length;
}

/* How many of the first `rank` rows are about to be lost together */
static int count_lost(int rank, const struct closed *c)
{
    int count = 1;
    const double nearest = fabs(c->diagonal[rank - 1]), first = fabs(c->diagonal[0]);
    while (count < rank && count < MOST_LOST && fabs(c->diagonal[rank - 1 - count]) < WIDEST * first &&
           fabs(c->diagonal[rank - 1 - count]) < ALIKE_LOST * fmax(nearest, BRIDGED * first))
        count++;
    return count;
}

enum outcome find_lost(struct system *s, const struct branch *b, struct closed *c, struct lost *l)
{
    const int n = s->n, r = b->rank, d = b->freedom, rows = s->model->rows;
    l->count = b->alone >= 0 ? 1 : count_lost(r, c);
    const int before = r - l->count;
    l->W = TAKE_ZEROS(s->arena, double, (size_t)l->count *rows);
    l->V = TAKE(s->arena, double, (size_t)l->count *n);
    l->K = TAKE(s->arena, double, (size_t)(d + l->count) * n);
    double *x = TAKE(s->arena, double, n);
    if (s->arena->ran_out)
        return OUTCOME_NO_MEMORY;
    l->size = fabs(c->diagonal[0]);
    for (int a = 0; a < l->count; a++) { /* rows `before` + a less what the first have of them, by back substitution */
        double *w = l->W + (size_t)a * rows;
        memcpy(x, c->g + (size_t)(before + a) * n, before * sizeof *x);
        w[c->order[before + a]] = 1.0;
        for (int k = before - 1; k >= 0; k--) {
            for (int j = k + 1; j < before; j++)
                x[k] -= c->g[(size_t)j * n + k] * x[j];
            x[k] /= c->diagonal[k];
            w[c->order[k]] = -x[k];
        }
    }
    for (int j = 0; j < d + l->count; j++)
        column_of_factor(n, before, c, before + j, l->K + (size_t)j * n);
    return OUTCOME_DONE;
}

enum outcome rows_of_lost(struct system *s, const struct lost *l, const double *q, double *row)
{
    const size_t n = s->n, rows = s->model->rows;
    const struct mark mark = s->arena->top;
    double *g = TAKE(s->arena, double, (rows * n)), *length = TAKE(s->arena, double, rows);
    double *at = TAKE(s->arena, double, n);
    const enum outcome outcome = s->arena->ran_out ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    for (size_t i = 0; i < n && !outcome; i++)
        at[i] = q[i] * s->unit[i];
    if (!outcome) {
        memset(row, 0, l->count * n * sizeof *row);
        scaled_closure_rows(s, at, g, length);
        for (int a = 0; a < l->count; a++)
            for (size_t j = 0; j < rows; j++)
                for (size_t i = 0; i < n && l->W[a * rows + j] != 0.0; i++)
                    row[a * n + i] += l->W[a * rows + j] * g[j * n + i];
    }
    give_back(s->arena, mark);
    return outcome;
}

enum outcome change_of_lost(struct system *s, const struct lost *l, const double *q, const double *x, double *change)
{
    const size_t n = s->n;
    const double h = pow(DBL_EPSILON, 1.0 / 3.0);
    const struct mark mark = s->arena->top;
    double *row = TAKE(s->arena, double, l->count *n), *there = TAKE(s->arena, double, n);
    enum outcome outcome = s->arena->ran_out ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    if (!outcome)
        memset(change, 0, l->count * n * sizeof *change);
    for (int side = -1; side <= 1 && !outcome; side += 2) {
        for (size_t i = 0; i < n; i++)
            there[i] = q[i] + side * h * x[i];
        outcome = rows_of_lost(s, l, there, row);
        for (size_t i = 0; i < l->count * n && !outcome; i++)
            change[i] += side * row[i] / (2.0 * h);
    }
    give_back(s->arena, mark);
    return outcome;
}

/* The largest number whose rounding the closure at q[n] has, in units: positions of links, or coordinates; at least 1. Infinite when memory runs out */
static double farthest_place(const struct system *s, const double *q)
{
    const size_t links = s->model->links;
    const struct mark mark = s->arena->top;
    double *poses = TAKE(s->arena, double, 3 * links), found = 1.0;
    if (s->arena->ran_out) {
        give_back(s->arena, mark);
        return INFINITY;
    }
    s->model->poses(s->k, q, poses);
    for (size_t k = 0; k < links; k++)
        found = fmax(found, fmax(fabs(poses[3 * k]), fabs(poses[3 * k + 1])) / s->length);
    for (int i = 0; i < s->n; i++)
        found = fmax(found, fabs(q[i]) / s->unit[i]);
    give_back(s->arena, mark);
    return found;
}

enum { ROUNDINGS = 4 }; /* of a sum of two positions that the closure is the difference of */

int lost_row_closes(const struct system *s, const struct closed *c, const struct lost *l, int number, const double *gap)
{
    double miss = 0.0, known = 0.0;
    for (int j = 0; j < s->model->rows; j++) {
        const double w = l->W[(size_t)number * s->model->rows + j] / c->length[j];
        miss += w * gap[j];
        known += fabs(w) * s->length;
    }
    return fabs(miss) <= ROUNDINGS * DBL_EPSILON * farthest_place(s, c->q) * known;
}

/* l->V: what of l->K is across the tangents at the place */
static enum outcome find_across(struct system *s, const struct branch *b, const struct branch_place *p, struct lost *l)
{
    const int n = s->n, d = b->freedom, all = d + l->count;
    const struct mark mark = s->arena->top;
    double *basis = TAKE(s->arena, double, (size_t)all *n), *v = TAKE(s->arena, double, n);
    const enum outcome outcome = s->arena->ran_out ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    for (int j = 0; j < d && !outcome; j++) {
        memcpy(basis + (size_t)j * n, p->T + (size_t)j * n, n * sizeof *basis);
        make_orthogonal(n, j, basis, basis + (size_t)j * n);
    }
    for (int a = 0; a < l->count && !outcome; a++) {
        double most = -1.0, *to = basis + (size_t)(d + a) * n;
        for (int j = 0; j < all; j++) {
            memcpy(v, l->K + (size_t)j * n, n * sizeof *v);
            const double length = make_orthogonal(n, d + a, basis, v);
            if (length > most) {
                most = length;
                memcpy(to, v, n * sizeof *v);
            }
        }
        memcpy(l->V + (size_t)a * n, to, n * sizeof *to);
    }
    give_back(s->arena, mark);
    return outcome;
}

/* The least pivot of sum e_i D_i, D[freedom][count][count]; M[count][count] is scratch. */
static double least_pivot(int d, int count, const double *e, const double *D, double *M)
{
    double diagonal[MOST_LOST], beta[MOST_LOST];
    int order[MOST_LOST];
    memset(M, 0, (size_t)count * count * sizeof *M);
    for (int i = 0; i < d; i++)
        for (int a = 0; a < count * count; a++)
            M[a] += e[i] * D[(size_t)i * count * count + a];
    for (int a = 0; a < count; a++)
        order[a] = a;
    return reduce_columns(count, count, M, 0.0, diagonal, beta, order) < count ? 0.0 : fabs(diagonal[count - 1]);
}

/* Of the gradients of all entries, and their sum along the diagonal, that along which the rows that are lost come back the fastest */
static void choose_ray(int d, int count, const double *D, double *trial, double *M, struct crossing *x)
{
    x->slope = -1.0;
    for (int a = 0; a <= count * count; a++) {
        double length = 0.0;
        for (int i = 0; i < d; i++) {
            const double *entries = D + (size_t)i * count * count;
            trial[i] = a < count * count ? entries[a] : 0.0;
            for (int j = 0; j < count && a == count * count; j++)
                trial[i] += entries[j * count + j];
            length += trial[i] * trial[i];
        }
        for (int i = 0; i < d && length > 0.0; i++)
            trial[i] /= sqrt(length);
        const double slope = length > 0.0 ? least_pivot(d, count, trial, D, M) : 0.0;
        if (slope > x->slope) {
            x->slope = slope;
            memcpy(x->e, trial, d * sizeof *trial);
        }
    }
}

enum outcome find_crossing(struct system *s, const struct branch *b, struct closed *c, struct crossing *x)
{
    const int n = s->n, d = b->freedom;
    const struct mark mark = s->arena->top;
    struct lost l;
    enum outcome outcome = factorise_closure(s, b, b->known.q, c);
    outcome = outcome ? outcome : find_lost(s, b, c, &l);
    outcome = outcome ? outcome : find_across(s, b, &b->known, &l);
    if (outcome)
        goto end;
    const size_t square = (size_t)l.count * l.count;
    double *D = TAKE(s->arena, double, d *square), *now = TAKE(s->arena, double, square);
    double *change = TAKE(s->arena, double, (size_t)l.count *n), *trial = TAKE(s->arena, double, d);
    double *M = TAKE(s->arena, double, square), *row = TAKE(s->arena, double, (size_t)l.count *n);
    outcome = s->arena->ran_out ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    for (int i = 0; i < d && !outcome; i++) {
        outcome = change_of_lost(s, &l, b->known.q, b->known.T + (size_t)i * n, change);
        for (int a = 0; a < l.count; a++)
            for (int v = 0; v < l.count; v++)
                D[i * square + a * l.count + v] = dot(n, change + (size_t)a * n, l.V + (size_t)v * n);
    }
    outcome = outcome ? outcome : rows_of_lost(s, &l, b->known.q, row);
    if (outcome)
        goto end;
    for (int a = 0; a < l.count; a++)
        for (int v = 0; v < l.count; v++)
            now[a * l.count + v] = dot(n, row + (size_t)a * n, l.V + (size_t)v * n);
    choose_ray(d, l.count, D, trial, M, x);
    double above = 0.0, below = 0.0;
    for (size_t a = 0; a < square; a++) {
        double along = 0.0;
        for (int i = 0; i < d; i++)
            along += x->e[i] * D[i * square + a];
        above += along * now[a];
        below += along * along;
    }
    x->slope /= l.size;
    x->place = -above / below;
    if (!(x->slope > FLAT) || !isfinite(x->place))
        outcome = OUTCOME_NOT_CLOSED;
end:
    give_back(s->arena, mark);
    return outcome;
}
