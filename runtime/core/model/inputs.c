/* Inputs of the model: what supplies them is asked at every state; a table is interpolated. */
#include "model/inputs.h"

#include <float.h>
#include <math.h>
#include <string.h>

int own_inputs(const struct ccgen_model *m)
{
    return m->inputs - m->switches - m->latches;
}

/* The sides at a state, from what effects hold behind them. What begins at an instant is there from that instant on. */
static void read_sides(const struct ccgen_model *m, const double *k, double t, const double *q, const double *u,
                       double *inputs)
{
    double *sides = inputs + own_inputs(m);
    const double size = fabs(t), after = t + 2.0 * DBL_EPSILON * size + DBL_MIN;
    m->switching(k, q, u, after, inputs, sides);
    for (int i = 0; i < m->switches; i++)
        sides[i] = unit_step(sides[i]);
}

void find_sides(const struct ccgen_model *m, const double *k, double t, const double *q, const double *u,
                double *inputs)
{
    if (m->latches)
        m->latching(k, q, u, t, inputs, inputs + own_inputs(m) + m->switches);
    read_sides(m, k, t, q, u, inputs);
}

/* What effects hold at a state, latched[latches]: what has been set; where nothing has yet, zero within a step, else what is set there */
static void recall(const struct system *s, double t, const double *q, const double *u, double *latched)
{
    const struct ccgen_model *m = s->model;
    if (m->latches && !s->sides)
        m->latching(s->k, q, u, t, s->inputs, latched);
    for (int i = 0; i < m->latches; i++)
        if (s->latched && !isnan(s->latched[i]))
            latched[i] = s->latched[i];
        else if (s->sides)
            latched[i] = 0.0;
}

enum outcome supply_inputs(struct system *s, double t, const double *q, const double *u)
{
    const struct ccgen_model *m = s->model;
    if (s->input_source && s->input_source(s->context, t, q, u, s->inputs)) {
        if (s->interruption)
            s->interruption->ended = 1;
        return OUTCOME_INTERRUPTED;
    }
    double *sides = s->inputs + own_inputs(m);
    recall(s, t, q, u, sides + m->switches);
    if (m->switches && s->sides)
        memcpy(sides, s->sides, m->switches * sizeof *s->sides);
    else if (m->switches)
        read_sides(m, s->k, t, q, u, s->inputs);
    return OUTCOME_DONE;
}

int input_from_table(void *context, double t, const double *q, const double *u, double *inputs)
{
    struct input_table *table = context;
    const size_t last = table->count - 1;
    size_t low = table->row;
    (void)q;
    (void)u;
    if (low >= last || t < table->t[low] || t >= table->t[low + 1]) { /* another interval: bisection */
        size_t high = last;
        low = 0;
        while (high > low + 1) {
            const size_t middle = low + (high - low) / 2;
            if (t < table->t[middle])
                high = middle;
            else
                low = middle;
        }
        table->row = low;
    }
    const double *a = table->values + low * table->width, *b = low < last ? a + table->width : a;
    const double length = low < last ? table->t[low + 1] - table->t[low] : 1.0, part = (t - table->t[low]) / length;
    for (int i = 0; i < table->width; i++)
        inputs[i] = part <= 0.0 ? a[i] : part >= 1.0 ? b[i] : a[i] + part * (b[i] - a[i]);
    return 0;
}
