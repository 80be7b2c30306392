/* What lies near a configuration at which rows of the closure are all but dependent (docs/theory, eq. 8.11).
 *
 * The rows W that are about to be lost miss phi(z) = W g along the directions K that the others leave, those being kept closed: the reduction of Lyapunov and Schmidt
 * (M. Golubitsky, D. G. Schaeffer, Singularities and Groups in Bifurcation Theory I, 1985, chapter VII). The place is where phi has no gradient, W A K = 0; Newton's
 * iteration finds it, with derivatives B of the gradient by differences. An error e of the place moves phi there by e^2 only, so that it tells to rounding whether the loops close at it:
 *
 *     they do, and B has two signs, one of each: two branches cross;
 *     they do not, or B has other signs: no branch crosses, and motions pass the place by.
 */
#include "constraints/place.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "algebra/dot.h"
#include "algebra/orthogonal.h"
#include "base/tolerances.h"
#include "constraints/crossing.h"

enum { PASSES = 12 };
static const double FLAT = 1e-3;     /* of the most that rows turn by what turns them by less turns none */
static const double FARTHEST = 0.5;  /* the longest correction */
static const double KNOWN = 64.0;    /* roundings of a gradient */
static const double NEAR = 10.0;     /* times as far as rows are from dependence another place is looked for */
static const double ROUNDINGS = 4.0; /* of a step of the iteration that is none */

/* The gradients along all directions that the rows which are kept leave, and how these change along them */
struct gradients {
    int count, all;     /* lost rows, directions */
    double *now, *turn; /* [count][all], [count][all][all] */
};

static enum outcome find_gradients(struct system *s, const double *q, const struct lost *l, struct gradients *g)
{
    const int n = s->n, all = g->all;
    const struct mark mark = s->arena->top;
    double *row = TAKE(s->arena, double, (size_t)l->count *n);
    enum outcome outcome = s->arena->ran_out ? OUTCOME_NO_MEMORY : rows_of_lost(s, l, q, row);
    for (int a = 0; a < l->count && !outcome; a++)
        for (int j = 0; j < all; j++)
            g->now[a * all + j] = dot(n, row + (size_t)a * n, l->K + (size_t)j * n);
    for (int i = 0; i < all && !outcome; i++) {
        outcome = change_of_lost(s, l, q, l->K + (size_t)i * n, row);
        for (int a = 0; a < l->count; a++)
            for (int j = 0; j < all; j++)
                g->turn[((size_t)a * all + j) * all + i] = dot(n, row + (size_t)a * n, l->K + (size_t)j * n);
    }
    give_back(s->arena, mark);
    return outcome;
}

/* z[all]: the shortest motion along the directions by which the gradients change by right[count][all] */
static enum outcome solve_gradients(struct system *s, const struct gradients *g, const double *right, double *z)
{
    const int all = g->all, rows = g->count * all;
    const struct mark mark = s->arena->top;
    double *B = TAKE(s->arena, double, (size_t)rows *all), *diagonal = TAKE(s->arena, double, rows);
    double *beta = TAKE(s->arena, double, rows);
    int *order = TAKE(s->arena, int, rows);
    const enum outcome outcome = s->arena->ran_out ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    if (!outcome) {
        memcpy(B, g->turn, (size_t)rows * all * sizeof *B);
        memset(z, 0, all * sizeof *z);
        for (int k = 0; k < rows; k++)
            order[k] = k;
        const int rank = reduce_columns(all, rows, B, FLAT, diagonal, beta, order);
        for (int k = 0; k < rank; k++)
            z[k] = right[order[k]];
        solve_transposed_triangle(all, rank, B, diagonal, z);
        reflect(all, rank, B, beta, 0, z);
    }
    give_back(s->arena, mark);
    return outcome;
}

/* x[n] in units: the shortest way along the directions to where the gradients vanish to first order, and that which closes the rows that are kept */
static enum outcome find_way(struct system *s, const struct branch *b, struct closed *c, const struct lost *l,
                             const struct gradients *g, double *x)
{
    const int n = s->n, all = g->all, rows = g->count * all, before = b->rank - l->count;
    const struct mark mark = s->arena->top;
    double *z = TAKE(s->arena, double, all), *gap = TAKE(s->arena, double, s->model->rows);
    double *right = TAKE(s->arena, double, rows);
    enum outcome outcome = s->arena->ran_out ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    for (int k = 0; k < rows && !outcome; k++)
        right[k] = -g->now[k];
    outcome = outcome ? outcome : solve_gradients(s, g, right, z);
    if (outcome)
        goto end;
    memset(x, 0, n * sizeof *x);
    s->model->closure(s->k, c->q, gap);
    for (int k = 0; k < before; k++)
        x[k] = -gap[c->order[k]] / c->length[c->order[k]];
    solve_transposed_triangle(n, before, c->g, c->diagonal, x);
    reflect(n, before, c->g, c->beta, 0, x);
    for (int j = 0; j < all; j++)
        for (int i = 0; i < n; i++)
            x[i] += z[j] * l->K[(size_t)j * n + i];
end:
    give_back(s->arena, mark);
    return outcome;
}

/* Factorise the rows at q[n], of which those that are about to be lost may be lost already. */
static enum outcome factorise_beside(struct system *s, const struct branch *b, const double *q, struct closed *c)
{
    for (int i = 0; i < s->n; i++)
        c->q[i] = q[i] * s->unit[i];
    const int rank = reduce_rows(s, 0.0, b->alone, c);
    for (int k = rank; k < b->rank; k++)
        c->diagonal[k] = 0.0;
    return rank < b->rank - MOST_LOST || !rank ? OUTCOME_NOT_CLOSED : OUTCOME_DONE;
}

/* Whether two branches cross where lost row a closes: its B, which is symmetric, has rank two and both signs, and so more of squares than of its trace. -1 when memory runs out */
static int has_two_branches(struct system *s, const struct gradients *g, int a)
{
    const int all = g->all;
    const double *B = g->turn + (size_t)a * all * all;
    const struct mark mark = s->arena->top;
    double *columns = TAKE(s->arena, double, (size_t)all *all), *diagonal = TAKE(s->arena, double, all),
           *beta = TAKE(s->arena, double, all);
    int *order = TAKE(s->arena, int, all), found = -1;
    double trace = 0.0, square = 0.0;
    if (s->arena->ran_out)
        goto end;
    for (int i = 0; i < all; i++) {
        order[i] = i;
        trace += B[i * all + i];
    }
    for (int i = 0; i < all * all; i++)
        square += B[i] * B[i];
    memcpy(columns, B, (size_t)all * all * sizeof *B);
    found = reduce_columns(all, all, columns, FLAT, diagonal, beta, order) == 2 && trace * trace < square;
end:
    give_back(s->arena, mark);
    return found;
}

/* What the place at c->q is */
static enum outcome decide(struct system *s, struct branch *b, const struct closed *c, const struct lost *l,
                           const struct gradients *g, int *alone)
{
    const struct mark mark = s->arena->top;
    const int rows = s->model->rows;
    double *gap = TAKE(s->arena, double, rows);
    int crosses = 1, closed = 1;
    if (s->arena->ran_out) {
        give_back(s->arena, mark);
        return OUTCOME_NO_MEMORY;
    }
    if (write_gaps(s, b, c, gap)) {
        give_back(s->arena, mark);
        return OUTCOME_NO_MEMORY;
    }
    for (int a = 0; a < l->count; a++) {
        const int shut = lost_row_closes(s, c, l, a, gap);
        closed &= shut;
        const int two = has_two_branches(s, g, a);
        if (two < 0) {
            give_back(s->arena, mark);
            return OUTCOME_NO_MEMORY;
        }
        crosses &= shut && two;
        *alone = shut && two ? c->order[b->rank - l->count + a] : *alone;
    }
    *alone = crosses ? -1 : *alone;
    b->kind = crosses ? CROSSES : PASSES_BY;
    b->placed = !crosses;
    for (int i = 0; i < s->n; i++)
        b->place[i] = crosses ? 0.0 : c->q[i];
    for (int j = 0; j < rows; j++)
        b->offset[j] = closed ? 0.0 : gap[j];
    give_back(s->arena, mark);
    return OUTCOME_DONE;
}

/* Room for the gradients of rows that are lost */
static enum outcome take_gradients(struct system *s, const struct branch *b, const struct lost *l, struct gradients *g)
{
    g->count = l->count;
    g->all = b->freedom + l->count;
    const size_t rows = (size_t)g->count * g->all;
    g->now = TAKE(s->arena, double, rows);
    g->turn = TAKE(s->arena, double, (rows * g->all));
    return s->arena->ran_out ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
}

/* Of velocities u[n] the part along[n] that turns rows, per unit of the fastest, and later[count][all] the gradients' rates along it */
static enum outcome find_turning(struct system *s, const struct lost *l, const struct gradients *g, const double *u,
                                 double *later, double *along)
{
    const int n = s->n, all = g->all;
    const struct mark mark = s->arena->top;
    const double speed = fastest(s, u);
    double *z = TAKE(s->arena, double, all);
    enum outcome outcome = s->arena->ran_out ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    memset(along, 0, n * sizeof *along);
    for (int j = 0; j < all && !outcome; j++) {
        z[j] = 0.0;
        for (int i = 0; i < n; i++)
            z[j] += l->K[(size_t)j * n + i] * u[i] / s->unit[i] / speed;
    }
    for (int k = 0; k < g->count * all && !outcome; k++)
        later[k] = dot(all, g->turn + (size_t)k * all, z);
    outcome = outcome ? outcome : solve_gradients(s, g, later, z);
    for (int j = 0; j < all && !outcome; j++)
        for (int i = 0; i < n; i++)
            along[i] += z[j] * l->K[(size_t)j * n + i];
    give_back(s->arena, mark);
    return outcome;
}

enum outcome find_way_through(struct system *s, const struct branch *b, struct closed *c, const double *q,
                              const double *u, struct way_through *way)
{
    const struct mark mark = s->arena->top;
    struct lost l;
    struct gradients g;
    *way = (struct way_through){.along = way->along};
    for (int j = 0; j < s->model->rows; j++)
        if (b->offset[j] != 0.0)
            return OUTCOME_DONE;
    if (!(fastest(s, u) > 0.0) || factorise_beside(s, b, q, c))
        return OUTCOME_DONE;
    enum outcome outcome = find_lost(s, b, c, &l);
    outcome = outcome ? outcome : take_gradients(s, b, &l, &g);
    outcome = outcome ? outcome : find_gradients(s, q, &l, &g);
    const int rows = outcome ? 0 : g.count * g.all;
    double *later = TAKE(s->arena, double, rows);
    if (!outcome && s->arena->ran_out)
        outcome = OUTCOME_NO_MEMORY;
    outcome = outcome ? outcome : find_turning(s, &l, &g, u, later, way->along);
    if (!outcome) {
        const double size = dot(rows, g.now, g.now), product = dot(rows, g.now, later),
                     square = dot(rows, later, later);
        const double across = sqrt(fmax(0.0, size - product * product / square)), noise = KNOWN * DBL_EPSILON * l.size;
        if (sqrt(square) > TELLS_BRANCH * l.size && across <= fmax(HEADED * sqrt(size), noise))
            way->turns = sqrt(square) / l.size;
        way->until = -product / square;
    }
    give_back(s->arena, mark);
    return outcome;
}

void forget_place(const struct system *s, struct branch *b)
{
    b->kind = UNDECIDED;
    b->alone = -1;
    b->placed = 0;
    memset(b->place, 0, s->n * sizeof *b->place); /* what is not known is the same in every state */
    memset(b->offset, 0, s->model->rows * sizeof *b->offset);
}

int stays_near_place(const struct system *s, const struct branch *b, const double *q, double margin)
{
    double most = 0.0;
    if (!b->placed)
        return 0;
    for (int i = 0; i < s->n; i++)
        most = fmax(most, fabs(q[i] - b->place[i]) / s->unit[i]);
    return most <= fmin(NEAR * margin, FARTHEST);
}

/* Whether the gradients vanish, as those cannot of several rows that depend at several places */
static int is_flat(const struct lost *l, const struct gradients *g)
{
    for (int k = 0; k < g->count * g->all; k++)
        if (!(fabs(g->now[k]) <= sqrt(DBL_EPSILON) * l->size))
            return 0;
    return 1;
}

static double distance(int n, const double *a, const double *b)
{
    double most = 0.0;
    for (int i = 0; i < n; i++)
        most = fmax(most, fabs(a[i] - b[i]));
    return most;
}

/* Find it where the rows that are about to be lost are, or b->alone; *alone is one that is lost at a crossing while others are not, or -1. */
static enum outcome search_place(struct system *s, struct branch *b, struct closed *c, const double *q, int *alone)
{
    const int n = s->n;
    const struct mark mark = s->arena->top;
    int found = 0;
    double *at = TAKE(s->arena, double, n), *x = TAKE(s->arena, double, n), last = INFINITY;
    enum outcome outcome = s->arena->ran_out ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    if (!outcome && b->rank < s->rows_on) /* rows that are redundant everywhere look as those that are lost here */
        outcome = OUTCOME_NOT_CLOSED;
    if (!outcome)
        memcpy(at, q, n * sizeof *q);
    for (int pass = 0; pass < PASSES && !outcome; pass++) {
        const struct mark inner = s->arena->top;
        struct lost l;
        outcome = factorise_beside(s, b, at, c);
        outcome = outcome ? outcome : find_lost(s, b, c, &l);
        if (outcome)
            break;
        struct gradients g;
        outcome = take_gradients(s, b, &l, &g);
        outcome = outcome ? outcome : find_gradients(s, at, &l, &g);
        outcome = outcome ? outcome : find_way(s, b, c, &l, &g, x);
        double size = 0.0;
        for (int i = 0; i < n && !outcome; i++) {
            at[i] += x[i];
            size = !(fabs(x[i]) <= size) ? fabs(x[i]) : size;
        }
        if (!outcome && !(size < FARTHEST))
            outcome = OUTCOME_NOT_CLOSED;
        found = !outcome && (size <= ROUNDINGS * DBL_EPSILON || (size > 0.5 * last && size < sqrt(DBL_EPSILON)));
        if (found && !(is_flat(&l, &g) && distance(n, at, q) < FARTHEST)) /* where it ends no place is */
            outcome = OUTCOME_NOT_CLOSED;
        found = found && !outcome;
        if (found)
            outcome = decide(s, b, c, &l, &g, alone);
        give_back(s->arena, inner);
        if (found)
            break;
        last = size;
    }
    if (!found)
        forget_place(s, b);
    give_back(s->arena, mark);
    return outcome == OUTCOME_NOT_CLOSED ? OUTCOME_DONE : outcome;
}

enum outcome find_place(struct system *s, struct branch *b, struct closed *c, const double *q)
{
    int alone = -1, none = -1;
    b->alone = -1;
    enum outcome outcome = search_place(s, b, c, q, &alone);
    if (outcome || alone < 0)
        return outcome;
    b->alone = alone;
    outcome = search_place(s, b, c, q, &none);
    if (b->kind != CROSSES) /* too far to be found by itself */
        forget_place(s, b);
    b->alone = alone;
    return outcome;
}
