/* Sides of effects in a phase, and what they hold; see kinks.h. */
#include "steps/kinks.h"

#include <math.h>
#include <string.h>

#include "model/inputs.h"
#include "motion/sides.h"

void forget_latches(struct phase *f)
{
    for (int i = 0; i < f->s->model->latches; i++)
        f->latched[i] = NAN;
    for (int i = 0; i < f->s->model->switches; i++)
        f->sides[i] = 0.0;
}

enum outcome hold_sides(struct phase *f, int direction)
{
    struct system *s = f->s;
    if (!s->model->switches)
        return OUTCOME_DONE;
    const enum outcome outcome = choose_sides(s, f->t, f->y, f->dy1, f->y1, direction, f->sides);
    s->sides = f->sides;
    return outcome;
}

enum outcome keep_latches(struct phase *f, const double *latched)
{
    if (!f->s->model->latches)
        return OUTCOME_DONE;
    memcpy(f->latched, latched, f->s->model->latches * sizeof *latched);
    const enum outcome outcome = hold_sides(f, -1);
    f->s->sides = NULL;
    return outcome;
}

/* Set what effects hold that have come to their side since they were on the sides before[switches], or hold nothing there yet. */
static enum outcome latch(struct phase *f, const double *before)
{
    struct system *s = f->s;
    const struct ccgen_model *m = s->model;
    const struct mark mark = s->arena->top;
    if (!m->latches)
        return OUTCOME_DONE;
    double *value = TAKE(s->arena, double, m->latches);
    enum outcome outcome = s->arena->ran_out ? OUTCOME_NO_MEMORY : supply_inputs(s, f->t, f->y, f->y + s->n);
    if (!outcome)
        m->latching(s->k, f->y, f->y + s->n, f->t, s->inputs, value);
    for (int i = 0; i < m->latches && !outcome; i++) {
        const int at = m->latched_at[i];
        if (f->sides[at] > 0.0 && (before[at] <= 0.0 || isnan(f->latched[i])))
            f->latched[i] = value[i];
    }
    record_latches(f);
    give_back(s->arena, mark);
    return outcome;
}

enum outcome begin_sides(struct phase *f)
{
    const size_t switches = f->s->model->switches;
    const struct mark mark = f->s->arena->top;
    if (!switches)
        return OUTCOME_DONE;
    double *before = TAKE(f->s->arena, double, switches);
    enum outcome outcome = f->s->arena->ran_out ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    if (!outcome)
        memcpy(before, f->sides, switches * sizeof *before);
    outcome = outcome ? outcome : hold_sides(f, 1);
    outcome = outcome ? outcome : latch(f, before);
    give_back(f->s->arena, mark);
    return outcome;
}

enum outcome change_side(struct phase *f, int kink)
{
    struct arena *arena = f->s->arena;
    const size_t switches = f->s->model->switches;
    const struct mark mark = arena->top;
    double *before = TAKE(arena, double, switches);
    enum outcome outcome = arena->ran_out ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    if (!outcome) {
        memcpy(before, f->sides, switches * sizeof *before);
        f->sides[kink] = 1.0 - f->sides[kink];
        outcome = latch(f, before);
    }
    give_back(arena, mark);
    return outcome;
}

enum outcome follow_sides(struct phase *f)
{
    struct system *s = f->s;
    const size_t switches = s->model->switches;
    const struct mark mark = s->arena->top;
    if (!s->model->latches)
        return OUTCOME_DONE;
    double *before = TAKE(s->arena, double, switches);
    enum outcome outcome = s->arena->ran_out ? OUTCOME_NO_MEMORY : supply_inputs(s, f->t, f->y, f->y + s->n);
    if (!outcome) {
        memcpy(before, f->sides, switches * sizeof *before);
        memcpy(f->sides, s->inputs + own_inputs(s->model), switches * sizeof *before);
        outcome = latch(f, before);
    }
    give_back(s->arena, mark);
    return outcome;
}
