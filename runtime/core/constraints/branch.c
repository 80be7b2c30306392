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
#include "constraints/place.h"
#include "constraints/rows.h"
#include "constraints/ray.h"

static const double FARTHEST_STATE = 10.0; /* the longest way from the beginning of the chart */
static const double CLEAR = 2.0; /* times as far from the place as what is interpolated the closure is taken as it is */
static const double STEEPEST = 4.0; /* the longest tangent in the chart, for a branch that turns */
enum { MOST_PIECES = 16 };          /* of a way in the chart along such a branch */
/* What of velocities may lie across the branch that they tell, as part of what tells it: more than a branch bends over the way on which they do, TELLS_TANGENTS, which is 6e-3 in
 * floats; what lies on no branch has as much across as along. */
static const double OFF_BRANCH = CCGEN_LIMIT(0.01, 0.1);

int take_branch(struct arena *arena, const struct ccgen_model *m, struct branch *b)
{
    const size_t n = m->nu;
    *b = (struct branch){.alone = -1};
    b->chart = TAKE(arena, double, (n * n));
    b->ray = TAKE(arena, double, n);
    b->through = TAKE(arena, double, n);
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

/* Whether the place is on the sheet on which the chart begins, and not too far turned against it */
static int lies_before_turn(const struct system *s, const struct branch *b, const struct branch_place *p)
{
    double most = 0.0;
    for (int i = 0; i < b->freedom; i++)
        most = fmax(most, dot(s->n, p->T + (size_t)i * s->n, p->T + (size_t)i * s->n));
    return most < STEEPEST * STEEPEST && p->turn * b->begins.turn >= 0;
}

/* The configuration at y of a branch that passes its place by, from the last known one on; NOT_CLOSED where the branch turns back before */
static enum outcome pass_by(struct system *s, struct branch *b, struct closed *c, const double *y)
{
    const int n = s->n, d = b->freedom;
    const struct mark mark = s->arena->top;
    struct branch_place from;
    enum outcome outcome = take_place(s->arena, n, &from) ? OUTCOME_NO_MEMORY : OUTCOME_NOT_CLOSED;
    for (int pieces = 1; pieces <= MOST_PIECES && outcome == OUTCOME_NOT_CLOSED; pieces *= 4) {
        copy_place(s, b, &b->known, &from);
        outcome = OUTCOME_DONE;
        for (int k = 1; k <= pieces && !outcome; k++) {
            for (int i = 0; i < d; i++)
                b->last.y[i] = k == pieces ? y[i] : b->known.y[i] + (y[i] - b->known.y[i]) * k / pieces;
            predict(n, d, &from, &b->last);
            outcome = close_at(s, b, c, &b->last);
            if (!outcome && !lies_before_turn(s, b, &b->last))
                outcome = OUTCOME_NOT_CLOSED;
            if (!outcome)
                copy_place(s, b, &b->last, &from);
        }
    }
    if (!outcome)
        copy_place(s, b, &b->last, &b->known);
    b->inside = 0;
    give_back(s->arena, mark);
    return outcome;
}

/* The configuration at y, of a motion that comes to a place at last */
static enum outcome come_to_place(struct system *s, struct branch *b, struct closed *c, const double *y)
{
    enum outcome outcome = b->kind == UNDECIDED ? find_place(s, b, c, b->known.q) : OUTCOME_DONE;
    if (!outcome && b->kind != PASSES_BY) {
        outcome = bridge(s, b, c, y);
        /* y alone may be out of reach of rays that are told, or beside the way through a place */
        if (outcome != OUTCOME_NOT_CLOSED || b->sampled || b->comes_back > 0.0) {
            b->kind = outcome && !b->sampled ? b->kind : CROSSES;
            return outcome;
        }
        if (b->alone >= 0)
            return OUTCOME_TWO_LINES;
        outcome = OUTCOME_DONE;
        b->kind = PASSES_BY; /* no place that rays through it tell */
        b->sampled = 0;
    }
    return outcome ? outcome : pass_by(s, b, c, y);
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
    if (!outcome && b->kind == PASSES_BY) {
        outcome = pass_by(s, b, &c, y);
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
    outcome = outcome ? outcome : come_to_place(s, b, &c, y);
end:
    give_back(s->arena, mark);
    return outcome;
}

void rewind_branch(struct branch *b)
{
    if (b->begins.margin >= BRIDGED ||
        b->kind == PASSES_BY) /* else the way back across the place is known, and that from there is not */
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
        const int rank = reduce_rows(s, RANK_TOLERANCE, -1, c);
        own = rank > own ? rank : own;
    }
    return own;
}

/* The way of the motion through its place, in the chart */
static void set_way_through(const struct system *s, struct branch *b, const struct way_through *way)
{
    double square = 0.0;
    b->comes_back = 0.0;
    if (!(way->turns > 0.0))
        return;
    for (int i = 0; i < b->freedom; i++) {
        b->through[i] = dot(s->n, b->chart + (size_t)i * s->n, way->along);
        square += b->through[i] * b->through[i];
    }
    for (int i = 0; i < b->freedom; i++)
        b->through[i] /= sqrt(square);
    b->until = way->until * sqrt(square);
    b->comes_back = way->turns / sqrt(square);
}

int moves(const struct system *s, const double *u)
{
    return fastest(s, u) * s->time > REST_SPEED;
}

/* b->rank and b->freedom; NOT_CLOSED where nothing tells a branch */
static enum outcome find_rank(struct system *s, struct branch *b, struct closed *c, const double *q, const double *u)
{
    memcpy(c->q, q, s->n * sizeof *q);
    int rank = reduce_rows(s, RANK_TOLERANCE, -1, c);
    const int deficient = rank < s->rows_on || (rank && fabs(c->diagonal[rank - 1]) < BRIDGED * fabs(c->diagonal[0]));
    if (!rank || (deficient && !moves(s, u))) /* what stands, and has not moved, tells no branch */
        return OUTCOME_NOT_CLOSED;
    if (!b->rank && deficient)
        rank = rank_beside(s, c, q, u, rank);
    b->rank = rank > b->rank ? rank : b->rank;
    b->freedom = s->n - b->rank;
    return OUTCOME_DONE;
}

/* How many rows count at q[n], and how near to dependence they are there; factorised in c */
static int reduce_at(struct system *s, const struct branch *b, const double *q, struct closed *c, double *margin)
{
    memcpy(c->q, q, s->n * sizeof *q);
    const int rank = reduce_rows(s, 0.0, b->alone, c);
    *margin = rank < b->rank ? 0.0 : fabs(c->diagonal[b->rank - 1] / c->diagonal[0]);
    return rank;
}

/* What lies near q[n], and the way of the motion through it */
static enum outcome find_place_of_motion(struct system *s, struct branch *b, struct closed *c, const double *q,
                                         const double *u, struct way_through *way)
{
    enum outcome outcome = OUTCOME_DONE;
    double margin;
    b->alone = -1;
    const int rank = reduce_at(s, b, q, c, &margin);
    if (margin >= BRIDGED || !b->placed)
        forget_place(s, b);
    else
        b->kind = PASSES_BY;
    if (margin < BRIDGED && rank >= b->rank - 1 && !stays_near_place(s, b, q, margin))
        outcome = find_place(s, b, c, b->begins.q);
    if (outcome || b->kind != PASSES_BY || !(margin < TELLS_TANGENTS))
        return outcome;
    outcome = find_way_through(s, b, c, b->begins.q, u, way);
    if (!outcome && way->turns > 0.0)
        b->kind = CROSSES;
    return outcome;
}

/* T0 where rows are reduced, and the way through the place */
static enum outcome choose_chart(struct system *s, struct branch *b, struct closed *c, int rank, const double *u,
                                 const struct way_through *way)
{
    const double margin = b->begins.margin;
    enum outcome outcome = OUTCOME_DONE;
    b->comes_back = 0.0;
    if (rank < b->rank - 1 || (b->kind == PASSES_BY && margin < RANK_TOLERANCE)) /* they tell no directions */
        return OUTCOME_NOT_CLOSED;
    if (b->kind == PASSES_BY || margin > TELLS_TANGENTS)
        for (int j = 0; j < b->freedom; j++)
            column_of_factor(s->n, b->rank, c, b->rank + j, b->chart + (size_t)j * s->n);
    else
        outcome = tangents_by_motion(s, b, c, u, b->chart);
    if (!outcome)
        set_way_through(s, b, way);
    return outcome;
}

enum outcome begin_branch(struct system *s, struct branch *b, const double *q, const double *given)
{
    const int n = s->n, stands = !moves(s, given);
    const double *u = stands ? b->heading : given; /* what has come to rest is on the branch that it came along */
    const struct mark mark = s->arena->top;
    struct branch widest = {.freedom = n, .alone = -1};
    struct closed c;
    struct way_through way = {.along = TAKE(s->arena, double, n)};
    enum outcome outcome = take_closed(s, &widest, &c) ? OUTCOME_NO_MEMORY : find_rank(s, b, &c, q, u);
    if (outcome)
        goto end;
    for (int i = 0; i < n; i++)
        b->begins.q[i] = q[i] / s->unit[i];
    memset(b->begins.y, 0, b->freedom * sizeof *b->begins.y);
    b->sampled = b->referenced = 0;
    outcome = find_place_of_motion(s, b, &c, q, u, &way);
    const int rank = reduce_at(s, b, q, &c, &b->begins.margin);
    outcome = outcome ? outcome : choose_chart(s, b, &c, rank, u, &way);
    memcpy(b->begins.T, b->chart, (size_t)b->freedom * n * sizeof *b->chart);
    b->begins.turn = 0;
    if (!outcome && (b->kind != CROSSES || b->begins.margin > TELLS_TANGENTS) &&
        !factorise_closure(s, b, b->begins.q, &c))
        b->begins.turn = c.turn;
    copy_place(s, b, &b->begins, &b->known);
    b->width = 0.0;
    memset(b->state, 0xff, 2 * (size_t)n * sizeof *b->state); /* no state: none is NaN */
    if (!outcome && !stands)
        memcpy(b->heading, u, n * sizeof *u);
end:
    give_back(s->arena, mark);
    return outcome;
}

int follows_at(struct system *s, const double *q)
{
    const struct branch *b = s->branch;
    double along = 0.0;
    if (b && b->kind == PASSES_BY)
        return is_place_on_branch(s, q) || closure_margin(s, q, b->rank) < CLEAR * BRIDGED;
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

int passes_by(const struct system *s)
{
    return s->branch && s->branch->kind != CROSSES;
}

int goes_through_crossing(const struct system *s)
{
    return s->branch && s->branch->kind == CROSSES && s->branch->comes_back == 0.0;
}

double nearest_margin(const struct system *s)
{
    return passes_by(s) ? fmin(s->branch->begins.margin, s->branch->last.margin) : 1.0;
}

double time_to_place(const struct system *s, const double *u)
{
    const struct branch *b = s->branch;
    double along = 0.0, square = 0.0;
    if (!b || b->kind != PASSES_BY || !b->placed)
        return 0.0;
    for (int i = 0; i < b->freedom; i++) {
        double way = 0.0, rate = 0.0;
        for (int l = 0; l < s->n; l++) {
            way += b->chart[(size_t)i * s->n + l] * (b->place[l] / s->unit[l] - b->begins.q[l]);
            rate += b->chart[(size_t)i * s->n + l] * u[l] / s->unit[l];
        }
        along += way * rate;
        square += rate * rate;
    }
    return along > 0.0 ? along / square : 0.0;
}

int is_place_on_branch(const struct system *s, const double *q)
{
    return s->branch && !memcmp(s->branch->state, q, s->n * sizeof *q);
}

int is_on_branch(const struct system *s, const double *q, const double *u)
{
    return is_place_on_branch(s, q) && !memcmp(s->branch->state + s->n, u, s->n * sizeof *u);
}

void read_state_on_branch(const struct system *s, double *q, double *u)
{
    memcpy(q, s->branch->state, s->n * sizeof *q);
    memcpy(u, s->branch->state + s->n, s->n * sizeof *u);
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
