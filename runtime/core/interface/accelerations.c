/* Accelerations in flight and what they change by; see ../../ccgen.h. */
#include <string.h>

#include "base/tolerances.h"
#include "base/within.h"
#include "interface/simulation.h"
#include "model/inputs.h"
#include "model/scales.h"
#include "motion/acceleration.h"
#include "motion/tangent.h"

/* The system of a simulation by itself: no contact is held, and nothing is remembered. Its inputs are taken from the arena. */
static enum outcome take_flight(const struct ccgen_simulation *it, double t, const double *q, const double *u,
                                const double *inputs, struct system *s)
{
    const struct ccgen_model *m = it->system.model;
    *s = it->system;
    s->active = NULL;
    s->sides = s->latched = NULL;
    s->interruption = NULL;
    s->baumgarte = 0.0;
    if (!all_finite(s->n, q) || !all_finite(s->n, u) || !all_finite(1, &t) ||
        (inputs && !all_finite(own_inputs(m), inputs)))
        return OUTCOME_NOT_FINITE;
    if (turned_far(s, q))
        return OUTCOME_TURNED_FAR;
    s->inputs = TAKE_ZEROS(s->arena, double, m->inputs);
    if (s->arena->ran_out)
        return OUTCOME_NO_MEMORY;
    if (inputs) {
        memcpy(s->inputs, inputs, own_inputs(m) * sizeof *inputs);
        s->input_source = NULL;
    }
    return OUTCOME_DONE;
}

static enum outcome accelerate_at(struct system *s, double t, const double *q, const double *u, double *u_dot,
                                  double *lambda)
{
    const enum outcome outcome = system_acceleration(s, t, q, u, u_dot, lambda);
    return outcome || all_finite(s->n, u_dot) ? outcome : OUTCOME_NOT_FINITE;
}

int ccgen_find_acceleration(struct ccgen_simulation *it, double t, const double *q, const double *u,
                            const double *inputs, double *u_dot)
{
    struct system s;
    const struct mark mark = it->arena.top;
    enum outcome outcome = take_flight(it, t, q, u, inputs, &s);
    double *lambda = TAKE(&it->arena, double, s.model->rows);
    if (!outcome)
        outcome = it->arena.ran_out ? OUTCOME_NO_MEMORY : accelerate_at(&s, t, q, u, u_dot, lambda);
    give_back(&it->arena, mark);
    return outcome;
}

static int blocks_of(int count, int lanes)
{
    return (count + lanes - 1) / lanes;
}

/* Blocks of directions of which each moves one of the first `count` entries of an argument of that size: zeros but for ones */
static double *unit_directions(struct arena *arena, int count, int size, int lanes)
{
    double *one = TAKE_ZEROS(arena, double, (size_t)blocks_of(count, lanes) * size * lanes);
    for (int j = 0; j < count && !arena->ran_out; j++)
        one[((size_t)(j / lanes) * size + j) * lanes + j % lanes] = 1.0;
    return one;
}

/* by[n][count] from tangents[blocks][every][lanes] of accelerations and what lies behind them */
static void put_rows(int n, int every, int lanes, const double *tangents, int count, double *by)
{
    for (int i = 0; by && i < n; i++)
        for (int j = 0; j < count; j++)
            by[i * count + j] = tangents[((size_t)(j / lanes) * every + i) * lanes + j % lanes];
}

static enum outcome derive_at(struct system *s, double t, const double *q, const double *u, const double *u_dot,
                              const double *lambda, double *by_q, double *by_u, double *by_inputs)
{
    const struct ccgen_model *m = s->model;
    const int n = s->n, lanes = m->derivatives->lanes, every = n + m->rows, own = own_inputs(m);
    const int states = blocks_of(n, lanes), others = blocks_of(own, lanes), blocks = 2 * states + others;
    const double *each = unit_directions(s->arena, n, n, lanes);
    struct directions along = {.blocks = blocks};
    along.by.q = along.by.u = each;
    along.by.t = TAKE_ZEROS(s->arena, double, (size_t)others *lanes);
    along.by.inputs = unit_directions(s->arena, own, m->inputs, lanes);
    along.count[MOVES_Q] = along.count[MOVES_U] = states;
    along.first[MOVES_U] = states;
    along.first[MOVES_K] = along.first[MOVES_T] = 2 * states;
    along.count[MOVES_T] = others;
    double *tangents = TAKE(s->arena, double, (size_t)blocks * every * lanes), miss;
    if (s->arena->ran_out)
        return OUTCOME_NO_MEMORY;
    const enum outcome outcome = acceleration_tangents(s, t, q, u, u_dot, lambda, &along, tangents, &miss);
    if (outcome)
        return outcome;
    if (!(miss <= DIRECTION_MISSED))
        return OUTCOME_DEPENDENT;
    const size_t part = (size_t)states * every * lanes;
    put_rows(n, every, lanes, tangents, n, by_q);
    put_rows(n, every, lanes, tangents + part, n, by_u);
    put_rows(n, every, lanes, tangents + 2 * part, own, by_inputs);
    return all_finite((size_t)blocks * every * lanes, tangents) ? OUTCOME_DONE : OUTCOME_NOT_FINITE;
}

int ccgen_derive_acceleration(struct ccgen_simulation *it, double t, const double *q, const double *u,
                              const double *inputs, double *u_dot, double *by_q, double *by_u, double *by_inputs)
{
    struct system s;
    const struct mark mark = it->arena.top;
    enum outcome outcome = take_flight(it, t, q, u, inputs, &s);
    double *lambda = TAKE(&it->arena, double, s.model->rows);
    if (!outcome && !s.model->derivatives)
        outcome = OUTCOME_NO_DERIVATIVES;
    if (!outcome)
        outcome = it->arena.ran_out ? OUTCOME_NO_MEMORY : accelerate_at(&s, t, q, u, u_dot, lambda);
    if (!outcome)
        outcome = derive_at(&s, t, q, u, u_dot, lambda, by_q, by_u, by_inputs);
    give_back(&it->arena, mark);
    return outcome;
}
