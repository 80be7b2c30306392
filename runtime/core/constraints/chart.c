/* A branch of the closure as a graph over its tangents T0 at one place, y = T0 (q - q0): where all rows count, the configuration at y follows by Newton's iteration, and its
 * tangents T = dq/dy with the same factors (docs/theory, eq. 8.8). */
#include "constraints/chart.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "algebra/dot.h"
#include "algebra/gauss_rule.h"
#include "algebra/orthogonal.h"
#include "algebra/power_of_two.h"
#include "base/tolerances.h"
#include "constraints/rows.h"

enum { PASSES = 12 };
static const double SHORT = CCGEN_LIMIT(0x1p-200, 0x1p-30); /* of a row, beside which no other is as short */

static const double FARTHEST = 0.5;       /* and the longest correction of it */
static const double FARTHEST_HOPS = 20.0; /* the longest way that is gone in pieces */
static const double REFERRED = 0.6; /* the longest way from a place by which gaps are integrals of rows, to rounding */

int take_place(struct arena *arena, size_t n, struct branch_place *p)
{
    p->y = TAKE(arena, double, n);
    p->q = TAKE(arena, double, n);
    p->T = TAKE(arena, double, (n * n));
    return arena->ran_out;
}

void copy_place(const struct system *s, const struct branch *b, const struct branch_place *from,
                struct branch_place *to)
{
    memcpy(to->y, from->y, b->freedom * sizeof *to->y);
    memcpy(to->q, from->q, s->n * sizeof *to->q);
    memcpy(to->T, from->T, (size_t)b->freedom * s->n * sizeof *to->T);
    to->margin = from->margin;
    to->turn = from->turn;
}

int take_closed(const struct system *s, const struct branch *b, struct closed *c)
{
    const size_t rows = s->model->rows, n = s->n, d = b->freedom;
    struct arena *arena = s->arena;
    c->g = TAKE(arena, double, (rows * n));
    c->length = TAKE(arena, double, rows);
    c->diagonal = TAKE_ZEROS(arena, double, rows);
    c->beta = TAKE(arena, double, rows);
    c->right = TAKE(arena, double, rows);
    c->order = TAKE(arena, int, rows);
    c->q = TAKE(arena, double, n);
    c->null = TAKE(arena, double, (d * n));
    c->across = TAKE(arena, double, (d * d));
    c->pivots = TAKE_ZEROS(arena, double, d);
    c->reflected = TAKE(arena, double, d);
    c->places = TAKE(arena, int, d);
    c->z = TAKE(arena, double, d);
    c->solved = TAKE(arena, double, d);
    c->margin = 0.0;
    c->turn = c->regular = 0;
    return arena->ran_out;
}

int reduce_rows(struct system *s, double nearest, int last, struct closed *c)
{
    const int rows = s->rows_on, n = s->n;
    scaled_closure_rows(s, c->q, c->g, c->length);
    keep_rows_on(s, c->g);
    for (int j = 0; j < rows; j++) {
        c->order[j] = s->on[j];
        if (s->on[j] == last) /* the shortest is taken last */
            multiply(n, SHORT, c->g + (size_t)j * n);
    }
    const int rank = reduce_columns(n, rows, c->g, nearest, c->diagonal, c->beta, c->order);
    if (last >= 0 && rank && c->order[rank - 1] == last) {
        multiply(rank - 1, 1.0 / SHORT, c->g + (size_t)(rank - 1) * n);
        c->diagonal[rank - 1] /= SHORT;
    }
    return rank;
}

void column_of_factor(int n, int rank, const struct closed *c, int number, double *x)
{
    memset(x, 0, n * sizeof *x);
    x[number] = 1.0;
    reflect(n, rank, c->g, c->beta, 0, x);
}

double closure_margin(struct system *s, const double *q, int rank)
{
    const struct mark mark = s->arena->top;
    const struct branch none = {.alone = -1};
    struct closed c;
    double margin = -1.0;
    if (!take_closed(s, &none, &c)) {
        memcpy(c.q, q, s->n * sizeof *q);
        const int own = reduce_rows(s, RANK_TOLERANCE, -1, &c);
        margin = own < rank ? 0.0 : own ? fabs(c.diagonal[own - 1] / c.diagonal[0]) : 1.0;
    }
    give_back(s->arena, mark);
    return margin;
}

/* 1 or -1: the sign of the determinant of factors, of a permutation, a triangle and a reflection for each column */
static int sign_of_factors(int count, const double *diagonal, const int *order)
{
    int sign = count % 2 ? -1 : 1;
    for (int k = 0; k < count; k++) {
        sign = diagonal[k] < 0.0 ? -sign : sign;
        for (int j = k + 1; j < count; j++)
            sign = order[j] < order[k] ? -sign : sign;
    }
    return sign;
}

enum outcome factorise_closure(struct system *s, const struct branch *b, const double *q, struct closed *c)
{
    const int n = s->n, r = b->rank, d = b->freedom;
    for (int i = 0; i < n; i++)
        c->q[i] = q[i] * s->unit[i];
    if (reduce_rows(s, 0.0, b->alone, c) < r)
        return OUTCOME_NOT_CLOSED;
    c->margin = r ? fabs(c->diagonal[r - 1] / c->diagonal[0]) : 1.0;
    for (int j = 0; j < d; j++)
        column_of_factor(n, r, c, r + j, c->null + (size_t)j * n);
    for (int i = 0; i < d; i++) {
        c->places[i] = i;
        for (int j = 0; j < d; j++)
            c->across[i * d + j] = dot(n, b->chart + (size_t)i * n, c->null + (size_t)j * n);
    }
    c->regular = reduce_columns(d, d, c->across, DBL_EPSILON, c->pivots, c->reflected, c->places) == d;
    const int redundant = r < s->rows_on;
    c->turn = redundant ? 0 : sign_of_factors(r, c->diagonal, c->order) * sign_of_factors(d, c->pivots, c->places);
    return OUTCOME_DONE;
}

/* x[n] += the direction that rows leave with T0 x = z[freedom]; solved[freedom] is scratch. */
static void add_along_rest(int n, int d, const struct closed *c, const double *z, double *solved, double *x)
{
    for (int k = 0; k < d; k++)
        solved[k] = z[c->places[k]];
    solve_transposed_triangle(d, d, c->across, c->pivots, solved);
    reflect(d, d, c->across, c->reflected, 0, solved);
    for (int j = 0; j < d; j++)
        for (int i = 0; i < n; i++)
            x[i] += solved[j] * c->null[(size_t)j * n + i];
}

int solve_in_chart(const struct system *s, const struct branch *b, struct closed *c, const double *y, double *x)
{
    const int n = s->n, r = b->rank, d = b->freedom;
    if (!c->regular)
        return 0;
    memset(x, 0, n * sizeof *x);
    for (int k = 0; k < r; k++)
        x[k] = c->right[c->order[k]] / c->length[c->order[k]];
    solve_transposed_triangle(n, r, c->g, c->diagonal, x);
    reflect(n, r, c->g, c->beta, 0, x);
    for (int i = 0; i < d; i++)
        c->z[i] = (y ? y[i] : 0.0) - dot(n, b->chart + (size_t)i * n, x);
    add_along_rest(n, d, c, c->z, c->solved, x);
    return 1;
}

/* With a place q* that the motion passes by, or that is on the branch, they are the integral of A along q - q* times that (eq. 8.10), and what the closure misses at q*: known
 * to rounding times the way, not to rounding, and so the better the nearer. */
enum outcome write_gaps(struct system *s, const struct branch *b, const struct closed *c, double *gap)
{
    const int n = s->n, rows = s->model->rows, by = b->kind == PASSES_BY;
    const double *from = by ? b->place : b->reference;
    const struct mark mark = s->arena->top;
    double most = (by ? b->placed : b->referenced) ? 0.0 : INFINITY;
    for (int i = 0; i < n && most < REFERRED; i++)
        most = fmax(most, fabs(c->q[i] - from[i]) / s->unit[i]);
    if (!(most <= REFERRED)) {
        s->model->closure(s->k, c->q, gap);
        return OUTCOME_DONE;
    }
    double *A = TAKE(s->arena, double, (size_t)rows *n), *way = TAKE(s->arena, double, n),
           *q = TAKE(s->arena, double, n);
    const enum outcome outcome = s->arena->ran_out ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    if (!outcome) {
        for (int j = 0; j < rows; j++)
            gap[j] = by ? b->offset[j] : 0.0;
        for (int i = 0; i < n; i++)
            way[i] = c->q[i] - from[i];
        for (int k = 0; k < STAGES; k++) {
            for (int i = 0; i < n; i++)
                q[i] = from[i] + NODE[k] * way[i];
            s->model->closure_jacobian(s->k, q, A);
            for (int j = 0; j < rows; j++)
                gap[j] += WEIGHT[k] * dot(n, A + (size_t)j * n, way);
        }
    }
    give_back(s->arena, mark);
    return outcome;
}

enum outcome close_at(struct system *s, const struct branch *b, struct closed *c, struct branch_place *p)
{
    const int n = s->n, d = b->freedom;
    const struct mark mark = s->arena->top;
    double *x = TAKE(s->arena, double, n), *y = TAKE(s->arena, double, d), last = INFINITY;
    enum outcome outcome = s->arena->ran_out ? OUTCOME_NO_MEMORY : OUTCOME_NOT_CLOSED;
    for (int pass = 0; pass < PASSES && outcome == OUTCOME_NOT_CLOSED; pass++) {
        if (interrupted(s->interruption, n)) {
            outcome = OUTCOME_INTERRUPTED;
            break;
        }
        if (factorise_closure(s, b, p->q, c))
            break;
        if (write_gaps(s, b, c, c->right)) {
            outcome = OUTCOME_NO_MEMORY;
            break;
        }
        for (int j = 0; j < s->model->rows; j++)
            c->right[j] = -c->right[j];
        for (int i = 0; i < d; i++) {
            y[i] = p->y[i];
            for (int l = 0; l < n; l++)
                y[i] -= b->chart[(size_t)i * n + l] * (p->q[l] - b->begins.q[l]);
        }
        double size = 0.0;
        if (!solve_in_chart(s, b, c, y, x))
            break;
        for (int i = 0; i < n; i++) {
            size = !(fabs(x[i]) <= size) ? fabs(x[i]) : size;
            p->q[i] += x[i];
        }
        if (!(size < FARTHEST))
            break;
        if (size <= 4.0 * DBL_EPSILON || (size > 0.5 * last && size < sqrt(DBL_EPSILON)))
            outcome = OUTCOME_DONE;
        last = size;
    }
    if (!outcome && !c->regular)
        outcome = OUTCOME_NOT_CLOSED;
    for (int i = 0; i < d && !outcome; i++) {
        memset(y, 0, d * sizeof *y);
        y[i] = 1.0;
        memset(p->T + (size_t)i * n, 0, n * sizeof *p->T);
        add_along_rest(n, d, c, y, c->solved, p->T + (size_t)i * n);
    }
    p->margin = c->margin;
    p->turn = c->turn;
    give_back(s->arena, mark);
    return outcome;
}

void predict(int n, int d, const struct branch_place *from, struct branch_place *to)
{
    if (to->q != from->q)
        memcpy(to->q, from->q, n * sizeof *to->q);
    for (int i = 0; i < d; i++)
        for (int l = 0; l < n; l++)
            to->q[l] += (to->y[i] - from->y[i]) * from->T[(size_t)i * n + l];
}

enum outcome go_along(struct system *s, const struct branch *b, struct closed *c, struct branch_place *p,
                      const double *way)
{
    const int n = s->n, d = b->freedom;
    const struct mark mark = s->arena->top;
    struct branch_place to;
    enum outcome outcome = take_place(s->arena, n, &to) ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    const double length = sqrt(dot(d, way, way));
    const int pieces = length < FARTHEST_HOPS ? 1 + (int)(length / HOP) : 0;
    if (!pieces && !outcome)
        outcome = OUTCOME_NOT_CLOSED;
    for (int k = 0; k < pieces && !outcome; k++) {
        for (int i = 0; i < d; i++)
            to.y[i] = p->y[i] + way[i] / pieces;
        predict(n, d, p, &to);
        outcome = close_at(s, b, c, &to);
        if (!outcome)
            copy_place(s, b, &to, p);
    }
    give_back(s->arena, mark);
    return outcome;
}
