/* The motion along a step of a run, found anew from its start at nodes of collocation, for its derivatives (docs/theory, section
 * 11.5): sweeps from accelerations that lead from the step's start to its end. */
#include "interface/collocation.h"

#include <math.h>
#include <string.h>

#include "motion/acceleration.h"
#include "motion/lanes.h"

/* States at the nodes, and room for what `held_forces` tells beside their accelerations */
struct room {
    double *t, *q, *u;                        /* [stages], [stages][n] */
    double *next;                             /* [stages][n] accelerations of the next sweep */
    double *lambda, *push, *reactions, *told; /* as of held_forces */
};

static void take_room(struct system *s, int stages, struct room *r)
{
    const struct ccgen_model *m = s->model;
    const size_t k = stages, all = k * s->n;
    struct arena *arena = s->arena;
    *r = (struct room){.t = TAKE(arena, double, k),
                       .q = TAKE(arena, double, all),
                       .u = TAKE(arena, double, all),
                       .next = TAKE(arena, double, all),
                       .lambda = TAKE(arena, double, (k * (m->rows + 1))),
                       .push = TAKE(arena, double, (k * 2 * m->contacts)),
                       .reactions = TAKE(arena, double, (k * 3 * m->joints)),
                       .told = TAKE(arena, double, (k * m->told))};
}

/* Accelerations u_dot[count][n] of states one after the other in flight: as many at a time as there are lanes */
static enum outcome in_flight(struct system *s, size_t count, const double *t, const double *q, const double *u,
                              double *u_dot, double *lambda, double *when)
{
    const struct ccgen_model *m = s->model;
    const size_t n = s->n, lanes = m->lanes;
    const int side_by_side = count >= lanes && m->acceleration_states && !s->refine && !m->switches;
    const size_t block = side_by_side ? lanes : 1;
    for (size_t begin = 0; begin < count; begin += block) {
        const size_t first = begin + block <= count ? begin : count - block;
        unsigned lost = 1;
        if (side_by_side)
            lost = m->acceleration_states(s->k, q + first * n, u + first * n, t + first, s->inputs, u_dot + first * n,
                                          NULL);
        for (size_t i = first; lost; i++, lost >>= 1) {
            *when = t[i];
            const enum outcome outcome =
                lost & 1 ? system_acceleration(s, t[i], q + i * n, u + i * n, u_dot + i * n, lambda) : OUTCOME_DONE;
            if (outcome)
                return outcome;
        }
    }
    return OUTCOME_DONE;
}

static enum outcome accelerations(struct system *s, struct held held, size_t count, const double *t, const double *q,
                                  const double *u, struct room *r, double *u_dot, double *when)
{
    if (!held.count)
        return in_flight(s, count, t, q, u, u_dot, r->lambda, when);
    struct obstruction found;
    const enum outcome outcome =
        held_forces(s, count, 1, t, q, u, NULL, held, u_dot, r->lambda, r->push, r->reactions, r->told, NULL, &found);
    *when = t[found.state];
    return outcome;
}

/* Accelerations of rates that are a polynomial of degree 4, with those at both ends, and lead from one place to the next */
static void guess(const struct tableau *g, const struct stride *step, int n, double *W)
{
    const double h = step->h, *start = step->at_start, *end = step->at_end;
    for (int j = 0; j < g->stages; j++) {
        const double x = g->c[j], bump = 60.0 * x * (1.0 - x) * (1.0 - 2.0 * x) / h;
        const double of_change = 6.0 * x * (1.0 - x) / h;
        const double of_start = (3.0 * x - 4.0) * x + 1.0, of_end = (3.0 * x - 2.0) * x;
        for (int i = 0; i < n; i++) {
            const double mean = (step->q1[i] - step->q[i]) / h;
            const double ends = h / 12.0 * (start[i] - end[i]) + 0.5 * (step->u[i] + step->u1[i]);
            W[j * n + i] =
                of_change * (step->u1[i] - step->u[i]) + of_start * start[i] + of_end * end[i] + bump * (mean - ends);
        }
    }
}

/* Times, coordinates and rates at the nodes, of accelerations W[stages][n] there */
static void place_nodes(const struct tableau *g, const struct stride *step, int n, const double *W, struct room *r)
{
    const double h = step->h;
    for (int j = 0; j < g->stages; j++) {
        double *q = r->q + j * n, *u = r->u + j * n;
        r->t[j] = step->t + h * g->c[j];
        for (int i = 0; i < n; i++) {
            q[i] = step->q[i] + h * g->c[j] * step->u[i];
            u[i] = step->u[i];
        }
        for (int l = 0; l < g->stages; l++) {
            const double twice = h * h * g->twice[j * g->stages + l], once = h * g->A[j * g->stages + l];
            const double *w = W + l * n;
            for (int i = 0; i < n; i++) {
                q[i] += twice * w[i];
                u[i] += once * w[i];
            }
        }
    }
}

/* How large accelerations are, and what they differ by from others */
struct sizes {
    double size, change; /* the largest; not numbers where one is none */
};

enum { SIDE = 8 }; /* numbers side by side, which compilers make vectors of: as many as a step has nodes */

/* Of `count` numbers, as many as there are nodes of each coordinate */
static struct sizes measure(size_t count, const double *x, const double *others)
{
    double most[SIDE] = {0.0}, apart[SIDE] = {0.0}, sum[SIDE] = {0.0}, whole = 0.0;
    struct sizes found = {0.0, 0.0};
    for (size_t first = 0; first + SIDE <= count; first += SIDE)
        for (int l = 0; l < SIDE; l++) {
            const double size = fabs(x[first + l]), change = fabs(x[first + l] - others[first + l]);
            most[l] = size > most[l] ? size : most[l];
            apart[l] = change > apart[l] ? change : apart[l];
            sum[l] += size + change;
        }
    for (size_t i = count - count % SIDE; i < count; i++) {
        most[0] = fmax(most[0], fabs(x[i]));
        apart[0] = fmax(apart[0], fabs(x[i] - others[i]));
        sum[0] += fabs(x[i]) + fabs(x[i] - others[i]);
    }
    for (int l = 0; l < SIDE; l++) {
        found.size = most[l] > found.size ? most[l] : found.size;
        found.change = apart[l] > found.change ? apart[l] : found.change;
        whole += sum[l];
    }
    return isfinite(whole) ? found : (struct sizes){NAN, NAN};
}

/* What all nodes take with the model's own functions over lanes: value i of node j at [i * stages + j], or, of a block of as many nodes
 * as there are lanes, at [i * lanes + l] */
struct lanes {
    double *w, *next;          /* [n][stages] accelerations, and those of the next sweep */
    double *once, *twice, *c;  /* [blocks][stages][lanes] h A and its square, [stages] nodes */
    double *slope, *none;      /* [n] h u, and zeros */
    double *t, *q, *u, *u_dot; /* [lanes], [n][lanes] */
    double *scratch;
};

/* Whether the functions over lanes have all that acts, and nodes fill them */
static int fills_lanes(const struct system *s, struct held held, int stages)
{
    const struct ccgen_model *m = s->model;
    return !held.count && m->lanes > 1 && stages % m->lanes == 0 && m->stages && !s->refine && !m->switches;
}

static int take_lanes(struct system *s, const struct tableau *g, const struct stride *step, const double *W,
                      struct lanes *r)
{
    const size_t n = s->n, stages = g->stages, lanes = s->model->lanes, h_blocks = stages * stages;
    struct arena *arena = s->arena;
    *r = (struct lanes){.w = TAKE(arena, double, (n * stages)),
                        .next = TAKE(arena, double, (n * stages)),
                        .once = TAKE(arena, double, h_blocks),
                        .twice = TAKE(arena, double, h_blocks),
                        .c = TAKE(arena, double, stages),
                        .slope = TAKE(arena, double, n),
                        .none = TAKE_ZEROS(arena, double, n),
                        .t = TAKE(arena, double, lanes),
                        .q = TAKE(arena, double, (n * lanes)),
                        .u = TAKE(arena, double, (n * lanes)),
                        .u_dot = TAKE(arena, double, (n * lanes)),
                        .scratch = TAKE(arena, double, lanes_scratch(s))};
    if (arena->ran_out)
        return 0;
    memcpy(r->c, g->c, stages * sizeof *r->c);
    for (size_t i = 0; i < n; i++) {
        r->slope[i] = step->h * step->u[i];
        for (size_t j = 0; j < stages; j++)
            r->w[i * stages + j] = W[j * n + i];
    }
    for (size_t j = 0; j < stages; j++)
        for (size_t k = 0; k < stages; k++) {
            const size_t at = (k / lanes * stages + j) * lanes + k % lanes;
            r->once[at] = step->h * g->A[k * stages + j];
            r->twice[at] = step->h * step->h * g->twice[k * stages + j];
        }
    return 1;
}

/* Accelerations of the next sweep */
static enum outcome sweep_lanes(struct system *s, int stages, const struct stride *step, struct lanes *r)
{
    const struct ccgen_model *m = s->model;
    const int n = s->n, lanes = m->lanes;
    enum outcome outcome = OUTCOME_DONE;
    for (int b = 0; b < stages && !outcome; b += lanes) {
        double *block = lanes == stages ? r->next : r->u_dot;
        m->stages(n, stages, step->q, r->slope, r->c + b, r->twice + b * stages, r->w, r->q);
        m->stages(n, stages, step->u, r->none, r->c + b, r->once + b * stages, r->w, r->u);
        for (int l = 0; l < lanes; l++)
            r->t[l] = step->t + step->h * r->c[b + l];
        outcome = system_acceleration_lanes(s, s->model->lanes, r->t, r->q, r->u, block, r->scratch);
        for (int i = 0; i < n && block != r->next; i++)
            memcpy(r->next + i * stages + b, block + i * lanes, lanes * sizeof *block);
    }
    return outcome;
}

/* Accelerations of the next sweep, state by state or as the kernels take them; they stay away where places are no numbers any more */
static enum outcome sweep_states(struct system *s, struct held held, const struct tableau *g, const struct stride *step,
                                 struct room *r, const double *W, double *when)
{
    place_nodes(g, step, s->n, W, r);
    if (isfinite(measure((size_t)g->stages * s->n, r->q, r->q).size))
        return accelerations(s, held, g->stages, r->t, r->q, r->u, r, r->next, when);
    r->next[0] = NAN;
    return OUTCOME_DONE;
}

/* What is left after a sweep that has changed accelerations by so much, where changes fall at this rate: all that follow together. A
 * rate of a half or more says nothing of what follows but that it is not more. */
static double left_after(double change, double rate)
{
    return rate < 0.5 ? change * rate / (1.0 - rate) : change;
}

/* Sweep from W, or from accelerations over lanes where there are, until nothing changes but by rounding */
static enum outcome sweep(struct system *s, struct held held, const struct tableau *g, struct sweeping end,
                          const struct stride *step, struct room *r, struct lanes *lanes, double *W, int *met,
                          double *when)
{
    const size_t all = (size_t)g->stages * s->n;
    double *next = lanes ? lanes->next : r->next;
    double largest = measure(all, W, W).size, before = INFINITY, rate = 1.0;
    for (int k = 0; k < end.many; k++) {
        const enum outcome outcome =
            lanes ? sweep_lanes(s, g->stages, step, lanes) : sweep_states(s, held, g, step, r, W, when);
        if (outcome)
            return outcome;
        const struct sizes now = measure(all, next, W);
        if (!isfinite(now.change))
            return OUTCOME_DONE;
        memcpy(W, next, all * sizeof *W);
        largest = fmax(largest, now.size);
        const double last_rate = rate;
        rate = k ? now.change / before : 0.0;
        const int stands = now.change <= end.stays * largest;
        *met = left_after(now.change, fmax(rate, last_rate)) <= end.small * largest || (stands && rate >= 0.5);
        if (*met || (k > 4 && rate > 1.0 && !stands))
            return OUTCOME_DONE;
        before = now.change;
    }
    return OUTCOME_DONE;
}

/* The same over lanes; 0 where they have no accelerations, which states by themselves tell better */
static int found_in_lanes(struct system *s, struct held held, const struct tableau *g, struct sweeping end,
                          const struct stride *step, double *W, int *met)
{
    const int n = s->n, stages = g->stages;
    const struct mark mark = s->arena->top;
    struct lanes lanes;
    int found = 0;
    if (fills_lanes(s, held, stages) && take_lanes(s, g, step, W, &lanes))
        found = !sweep(s, held, g, end, step, NULL, &lanes, lanes.w, met, NULL);
    for (int j = 0; j < stages && found; j++)
        for (int i = 0; i < n; i++)
            W[j * n + i] = lanes.w[i * stages + j];
    give_back(s->arena, mark);
    return found;
}

enum outcome collocate_motion(struct system *s, struct held held, const struct tableau *g, struct sweeping end,
                              const struct stride *step, double *W, int *met, double *when)
{
    const struct mark mark = s->arena->top;
    struct room r;
    take_room(s, g->stages, &r);
    enum outcome outcome = s->arena->ran_out ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    *met = 0;
    *when = step->t;
    if (!outcome) {
        guess(g, step, s->n, W);
        if (!found_in_lanes(s, held, g, end, step, W, met))
            outcome = sweep(s, held, g, end, step, &r, NULL, W, met, when);
    }
    give_back(s->arena, mark);
    return outcome;
}
