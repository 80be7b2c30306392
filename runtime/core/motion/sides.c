/* Sides of effects with kinks; see sides.h. */
#include "motion/sides.h"

#include <math.h>

#include "base/tolerances.h"
#include "model/inputs.h"
#include "motion/derivative.h"

enum outcome side_functions(struct system *s, double t, const double *y, const double *sides, double *value)
{
    const struct ccgen_model *m = s->model;
    const enum outcome outcome = supply_inputs(s, t, y, y + s->n);
    if (outcome)
        return outcome;
    m->switching(s->k, y, y + s->n, t, s->inputs, value);
    for (int i = 0; i < m->switches; i++)
        value[i] = sides[i] > 0.0 ? value[i] : -value[i];
    return OUTCOME_DONE;
}

enum outcome side_noise(struct system *s, double t, const double *y, double *moved, double *value, double *there,
                        double *noise)
{
    enum { PATTERNS = 4 }; /* of signs: differences of neighbours see one, of others another */
    const struct ccgen_model *m = s->model;
    const enum outcome outcome = supply_inputs(s, t, y, y + s->n);
    for (int i = 0; i < m->switches; i++)
        noise[i] = 0.0;
    if (!outcome)
        m->switching(s->k, y, y + s->n, t, s->inputs, value);
    for (int pattern = 0; pattern < 2 * PATTERNS && !outcome; pattern++) {
        const int far = pattern >= PATTERNS, signs = pattern % PATTERNS;
        for (int i = 0; i < 2 * s->n; i++) {
            const double part = far ? 0.5 * s->unit[i] : SIDE_ROUNDING * fmax(fabs(y[i]), s->unit[i]);
            moved[i] = y[i] + (signs && (i % s->n) >> (signs - 1) & 1 ? -part : part);
        }
        m->switching(s->k, moved, moved + s->n, t, s->inputs, there);
        for (int i = 0; i < m->switches; i++)
            noise[i] = fmax(noise[i], (far ? 2.0 * SIDE_ROUNDING : 1.0) * fabs(there[i] - value[i]));
    }
    return outcome;
}

enum outcome choose_sides(struct system *s, double t, const double *y, double *dy, double *ahead, int direction,
                          double *sides)
{
    const struct ccgen_model *m = s->model;
    const double h = direction * NEXT_SIDE * s->time;
    const struct mark mark = s->arena->top;
    double *later = TAKE(s->arena, double, m->switches);
    s->sides = NULL;
    enum outcome outcome = s->arena->ran_out ? OUTCOME_NO_MEMORY : system_derivative(s, t, y, dy);
    if (!outcome) {
        for (int i = 0; i < 2 * s->n; i++)
            ahead[i] = y[i] + h * dy[i];
        m->switching(s->k, y, y + s->n, t, s->inputs, sides);
        m->switching(s->k, ahead, ahead + s->n, t + h, s->inputs, later);
        for (int i = 0; i < m->switches; i++)
            sides[i] = unit_step(fabs(later[i] - sides[i]) < fabs(sides[i]) ? sides[i] : later[i]);
    }
    give_back(s->arena, mark);
    return outcome;
}
