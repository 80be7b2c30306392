/* Accelerations of several states side by side. */
#include "motion/lanes.h"

#include "model/inputs.h"
#include "motion/acceleration.h"

/* scratch: inputs of the lanes, then one state and its acceleration */
size_t lanes_scratch(const struct system *s)
{
    const size_t lanes = s->model->lanes;
    return lanes * s->model->inputs + 3 * (size_t)s->n;
}

/* Whether the kernel over lanes has all that acts. Where it has not, states go one by one. */
int lanes_apply(const struct system *s)
{
    return s->baumgarte == 0.0 && !active_count(s) && !s->refine;
}

static void take(int n, int lanes, int lane, const double *from, double *to)
{
    for (int i = 0; i < n; i++)
        to[i] = from[(size_t)i * lanes + lane];
}

/* Inputs of every lane: each state asks for its own if there is a supply. */
static enum outcome supply_lanes(struct system *s, const double *t, const double *q, const double *u, double *inputs,
                                 double *one)
{
    const int lanes = s->model->lanes, count = s->model->inputs;
    for (int l = 0; l < lanes; l++) {
        if (s->input_source || s->model->switches) {
            take(s->n, lanes, l, q, one);
            take(s->n, lanes, l, u, one + s->n);
            const enum outcome outcome = supply_inputs(s, t[l], one, one + s->n);
            if (outcome)
                return outcome;
        }
        for (int i = 0; i < count; i++)
            inputs[(size_t)i * lanes + l] = s->inputs[i];
    }
    return OUTCOME_DONE;
}

enum outcome system_acceleration_lanes(struct system *s, int wanted, const double *t, const double *q, const double *u,
                                       double *u_dot, double *scratch)
{
    const struct ccgen_model *m = s->model;
    const int lanes = m->lanes, n = s->n;
    double *inputs = scratch, *one = inputs + (size_t)lanes * m->inputs;
    if (interrupted(s->interruption, (long)lanes * n))
        return OUTCOME_INTERRUPTED;
    if (m->inputs) {
        const enum outcome outcome = supply_lanes(s, t, q, u, inputs, one);
        if (outcome)
            return outcome;
    }
    unsigned lost = ~0u;
    if (lanes_apply(s))
        lost = m->acceleration_lanes(s->k, q, u, t, inputs, u_dot, NULL);
    s->evaluations += wanted < lanes ? wanted : lanes;
    if (!lost)
        return OUTCOME_DONE;
    const struct mark mark = s->arena->top;
    double *lambda = TAKE(s->arena, double, m->rows);
    enum outcome outcome = s->arena->ran_out ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    for (int l = 0; l < lanes && !outcome; l++) {
        if (!(lost >> l & 1) || l >= wanted)
            continue;
        take(n, lanes, l, q, one);
        take(n, lanes, l, u, one + n);
        s->evaluations--;
        outcome = system_acceleration(s, t[l], one, one + n, one + 2 * n, lambda);
        for (int i = 0; i < n && !outcome; i++)
            u_dot[(size_t)i * lanes + l] = one[2 * n + i];
    }
    give_back(s->arena, mark);
    return outcome;
}
