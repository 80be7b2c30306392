/* The branch of closed configurations on which a motion passes a place where closure rows are dependent (docs/theory, section 8).
 *
 * Through such a place the tangents of a branch are analytic, though the closure at the place leaves more directions open, and beside it knows
 * them to rounding / sigma^2 only. The branch is a graph over its tangents T0 at a place nearby: q(y), with T = dq/dy and the
 * accelerations a that go with constant rates in the chart,
 *
 *     g(q) = 0,  T0 (q - q0) = y;    [A; T0] T = [0; 1];    [A; T0] a = [-dA/dt u; 0],   u = T dy/dt.
 *
 * Nearer to dependence than BRIDGED they are interpolated (ray.c).
 */
#include "constraints/branch.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "algebra/dot.h"
#include "algebra/orthogonal.h"
#include "base/tolerances.h"
#include "constraints/crossing.h"
#include "constraints/rows.h"
#include "constraints/ray.h"

static const double FARTHEST_STATE = 10.0; /* the longest way from the beginning of the chart */
static const double CLEAR = 2.0; /* times as far from the place as what is interpolated the closure is taken as it is */
static const double OFF_BRANCH =
    0.01; /* what of velocities may lie across the branch that they tell, as part of what tells it */

int take_branch(struct arena *arena, const struct ccgen_model *m, struct branch *b)
{
    const size_t n = m->nu;
    *b = (struct branch){0};
    b->chart = TAKE(arena, double, (n * n));
    b->ray = TAKE(arena, double, n);
    b->middle = TAKE(arena, double, n);
    b->reference = TAKE(arena, double, n);
    b->state = TAKE(arena, double, 2 * n);
    b->node_bias = TAKE(arena, double, BRANCH_NODES *n);
    for (int i = 0; i < BRANCH_NODES; i++)
        take_place(arena, n, &b->nodes[i]);
    take_place(arena, n, &b->begins);
    take_place(arena, n, &b->known);
    return take_place(arena, n, &b->last);
}

static double square_of_way(int d, const double *from, const double *to)
{
    double sum = 0.0;
    for (int i = 0; i < d; i++)
        sum += (to[i] - from[i]) * (to[i] - from[i]);
    return sum;
}

/* The known place is the end of the ray on the side of y, if that is nearer or it lies on the other side: the way from there would lead across the place again. */
static void start_from_nearest(const struct system *s, struct branch *b, const double *y)
{
    const int side = along_ray(b, y) > 0.0;
    const struct branch_place *end = &b->nodes[side ? 0 : BRANCH_NODES - 1];
    if ((along_ray(b, b->known.y) > 0.0) != side ||
        square_of_way(b->freedom, end->y, y) < square_of_way(b->freedom, b->known.y, y))
        copy_place(s, b, end, &b->known);
}

enum outcome lift_branch(struct system *s, struct branch *b, const double *y)
{
    const int n = s->n, d = b->freedom;
    const struct mark mark = s->arena->top;
    struct closed c;
    double *way = TAKE(s->arena, double, d);
    enum outcome outcome = take_closed(s, b, &c) ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    if (!outcome &&
        !(dot(d, y, y) < FARTHEST_STATE * FARTHEST_STATE)) /* a stage of a step that is far too long, or no number */
        outcome = OUTCOME_NOT_CLOSED;
    if (!outcome && b->sampled && d == 1 && fabs(along_ray(b, y)) < b->half) {
        interpolate(s, b, y, along_ray(b, y) / b->half);
        goto end;
    }
    if (!outcome && b->sampled)
        start_from_nearest(s, b, y);
    while (!outcome && b->known.margin >= BRIDGED) {
        const double square = square_of_way(d, b->known.y, y);
        for (int i = 0; i < d; i++)
            way[i] = y[i] - b->known.y[i];
        const double part = square > HOP * HOP ? HOP / sqrt(square) : 1.0;
        for (int i = 0; i < d; i++)
            b->last.y[i] = part < 1.0 ? b->known.y[i] + part * way[i] : y[i];
        predict(n, d, &b->known, &b->last);
        outcome = close_at(s, b, &c, &b->last);
        if (outcome == OUTCOME_NOT_CLOSED || (!outcome && b->last.margin < BRIDGED)) {
            outcome = OUTCOME_DONE;
            break;
        }
        if (!outcome)
            copy_place(s, b, &b->last, &b->known);
        if (!outcome && part == 1.0) {
            b->inside = 0;
            goto end;
        }
    }
    outcome = outcome ? outcome : bridge(s, b, &c, y);
end:
    give_back(s->arena, mark);
    return outcome;
}

void rewind_branch(struct branch *b)
{
    if (b->begins.margin >= BRIDGED) /* else the way back across the place is known, and that from there is not */
        b->known.margin = -1.0;
}

/* The part of u[n] across the tangents T[freedom][n], which are orthonormal, as part of its fastest entry */
static double part_across(const struct system *s, int freedom, const double *T, const double *u)
{
    const int n = s->n;
    double across = 0.0;
    for (int i = 0; i < n; i++) {
        double left = u[i] / s->unit[i];
        for (int j = 0; j < freedom; j++) {
            double along = 0.0;
            for (int l = 0; l < n; l++)
                along += T[(size_t)j * n + l] * u[l] / s->unit[l];
            left -= along * T[(size_t)j * n + i];
        }
        across += left * left;
    }
    return sqrt(across) / fastest(s, u);
}

/* Tangents at a place where rows do not tell them: those directions v that the others leave, along which the lost ones stay so when they turn with the
 * motion, W (dA along u) v = 0, for the motion is one of them */
static enum outcome tangents_by_motion(struct system *s, struct branch *b, struct closed *c, const double *u, double *T)
{
    const int n = s->n, d = b->freedom;
    const struct mark mark = s->arena->top;
    const double speed = fastest(s, u);
    struct lost l;
    enum outcome outcome = speed > 0.0 ? find_lost(s, b, c, &l) : OUTCOME_NOT_CLOSED;
    if (outcome)
        goto end;
    const int all = d + l.count;
    double *along = TAKE(s->arena, double, n), *change = TAKE(s->arena, double, (size_t)l.count *n);
    double *rows = TAKE(s->arena, double, (size_t)l.count *all), *v = TAKE(s->arena, double, all);
    double diagonal[MOST_LOST], beta[MOST_LOST];
    int order[MOST_LOST];
    outcome = s->arena->ran_out ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    for (int i = 0; i < n && !outcome; i++)
        along[i] = u[i] / s->unit[i] / speed;
    outcome = outcome ? outcome : change_of_lost(s, &l, b->begins.q, along, change);
    if (outcome)
        goto end;
    for (int a = 0; a < l.count; a++) {
        order[a] = a;
        for (int j = 0; j < all; j++)
            rows[a * all + j] = dot(n, change + (size_t)a * n, l.K + (size_t)j * n);
    }
    const int rank = reduce_columns(all, l.count, rows, 0.0, diagonal, beta, order);
    const double turns = rank < l.count ? 0.0 : fabs(diagonal[rank - 1]) / l.size;
    if (!(turns > TELLS_BRANCH)) {
        outcome = OUTCOME_NOT_CLOSED;
        goto end;
    }
    for (int j = 0; j < d; j++) {
        memset(v, 0, all * sizeof *v);
        v[l.count + j] = 1.0;
        reflect(all, rank, rows, beta, 0, v);
        double *to = T + (size_t)j * n;
        memset(to, 0, n * sizeof *to);
        for (int k = 0; k < all; k++)
            for (int i = 0; i < n; i++)
                to[i] += v[k] * l.K[(size_t)k * n + i];
    }
    if (!(part_across(s, d, T, u) <= OFF_BRANCH * turns))
        outcome = OUTCOME_NO_BRANCH;
end:
    give_back(s->arena, mark);
    return outcome;
}

/* How many rows count a little further along the motion, either way; at least `own` */
static int rank_beside(struct system *s, struct closed *c, const double *q, const double *u, int own)
{
    const double speed = fastest(s, u);
    for (int side = -1; side <= 1 && speed > 0.0; side += 2) {
        for (int i = 0; i < s->n; i++)
            c->q[i] = q[i] + side * BRIDGED * u[i] / speed;
        const int rank = reduce_rows(s, RANK_TOLERANCE, c);
        own = rank > own ? rank : own;
    }
    return own;
}

enum outcome begin_branch(struct system *s, struct branch *b, const double *q, const double *u)
{
    const int n = s->n;
    const struct mark mark = s->arena->top;
    struct branch widest = {.freedom = n};
    struct closed c;
    enum outcome outcome = take_closed(s, &widest, &c) ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    if (outcome)
        goto end;
    memcpy(c.q, q, n * sizeof *q);
    int rank = reduce_rows(s, RANK_TOLERANCE, &c);
    double margin = rank ? fabs(c.diagonal[rank - 1] / c.diagonal[0]) : 1.0;
    const int deficient = margin < BRIDGED || rank < s->model->rows;
    if (!rank || (deficient && !(fastest(s, u) * s->time > REST_SPEED))) { /* what stands tells no branch */
        outcome = OUTCOME_NOT_CLOSED;
        goto end;
    }
    if (!b->rank && deficient)
        rank = rank_beside(s, &c, q, u, rank);
    b->rank = rank > b->rank ? rank : b->rank;
    b->freedom = n - b->rank;
    memcpy(c.q, q, n * sizeof *q);
    rank = reduce_rows(s, 0.0, &c);
    margin = rank < b->rank ? 0.0 : fabs(c.diagonal[b->rank - 1] / c.diagonal[0]);
    for (int i = 0; i < n; i++)
        b->begins.q[i] = q[i] / s->unit[i];
    memset(b->begins.y, 0, b->freedom * sizeof *b->begins.y);
    if (rank < b->rank - 1) /* tells no directions that are about to be lost */
        outcome = OUTCOME_NOT_CLOSED;
    else if (margin > TELLS_TANGENTS)
        for (int j = 0; j < b->freedom; j++)
            column_of_factor(n, b->rank, &c, b->rank + j, b->chart + (size_t)j * n);
    else
        outcome = tangents_by_motion(s, b, &c, u, b->chart);
    memcpy(b->begins.T, b->chart, (size_t)b->freedom * n * sizeof *b->chart);
    b->begins.margin = margin;
    copy_place(s, b, &b->begins, &b->known);
    b->sampled = b->referenced = 0;
    b->width = 0.0;
    memset(b->state, 0xff, 2 * (size_t)n * sizeof *b->state); /* no state: none is NaN */
end:
    give_back(s->arena, mark);
    return outcome;
}

int follows_at(const struct system *s, const double *q)
{
    const struct branch *b = s->branch;
    double along = 0.0;
    if (!b || !b->sampled)
        return b != NULL;
    for (int i = 0; i < b->freedom; i++) {
        double y = -b->middle[i];
        for (int l = 0; l < s->n; l++)
            y += b->chart[(size_t)i * s->n + l] * (q[l] / s->unit[l] - b->begins.q[l]);
        along += b->ray[i] * y;
    }
    return !(fabs(along) * b->slope > CLEAR * BRIDGED);
}

int is_place_on_branch(const struct system *s, const double *q)
{
    return s->branch && !memcmp(s->branch->state, q, s->n * sizeof *q);
}

int is_on_branch(const struct system *s, const double *q, const double *u)
{
    return is_place_on_branch(s, q) && !memcmp(s->branch->state + s->n, u, s->n * sizeof *u);
}

const double *branch_tangents(const struct branch *b)
{
    return b->last.T;
}

/* a[n] in units at a place, of rates[freedom] in the chart */
static enum outcome bias_at(struct system *s, const struct branch *b, struct closed *c, const struct branch_place *p,
                            const double *rates, double *u, double *a)
{
    const int n = s->n;
    const enum outcome outcome = factorise_closure(s, b, p->q, c);
    if (outcome)
        return outcome;
    memset(u, 0, n * sizeof *u);
    for (int i = 0; i < b->freedom; i++)
        for (int l = 0; l < n; l++)
            u[l] += rates[i] * p->T[(size_t)i * n + l] * s->unit[l];
    s->model->closure_bias(s->k, c->q, u, c->right);
    for (int j = 0; j < s->model->rows; j++)
        c->right[j] = -c->right[j];
    return solve_in_chart(s, b, c, NULL, a) ? OUTCOME_DONE : OUTCOME_NOT_CLOSED;
}

enum outcome branch_bias(struct system *s, double *a)
{
    struct branch *b = s->branch;
    const int n = s->n, d = b->freedom;
    const struct mark mark = s->arena->top;
    struct closed c;
    double *rates = TAKE(s->arena, double, d), *u = TAKE(s->arena, double, n), *part = TAKE(s->arena, double, n);
    enum outcome outcome = take_closed(s, b, &c) ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    for (int i = 0; i < d && !outcome; i++) {
        rates[i] = 0.0;
        for (int l = 0; l < n; l++)
            rates[i] += b->chart[(size_t)i * n + l] * b->state[n + l] / s->unit[l];
    }
    memset(a, 0, n * sizeof *a);
    const int keeps =
        b->inside && d == 1; /* with one freedom they go as the square of its rate, and are found once for all */
    const double unit_rate = 1.0, factor = keeps ? rates[0] * rates[0] : 1.0;
    for (int k = 0; k < (b->inside ? BRANCH_NODES : 1) && !outcome; k++) {
        double *found = keeps ? b->node_bias + (size_t)k * n : part;
        if (!keeps || !b->biased)
            outcome = bias_at(s, b, &c, b->inside ? &b->nodes[k] : &b->last, keeps ? &unit_rate : rates, u, found);
        for (int l = 0; l < n && !outcome; l++)
            a[l] += (b->inside ? b->weights[k] : 1.0) * factor * found[l] * s->unit[l];
    }
    b->biased |= keeps && !outcome;
    give_back(s->arena, mark);
    return outcome;
}
