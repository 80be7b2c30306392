/* The right-hand side: velocities, accelerations, and power where the system has an entry of work. */
#include "motion/derivative.h"

#include <string.h>

#include "model/inputs.h"
#include "motion/acceleration.h"
#include "motion/power.h"
#include "motion/projection.h"

static enum outcome derivative_at(struct system *s, double t, const double *y, double *dy)
{
    const enum outcome outcome = supply_inputs(s, t, y, y + s->n);
    if (outcome)
        return outcome;
    memcpy(dy, y + s->n, s->n * sizeof *dy);
    if (s->size == 2 * s->n)
        return accelerate(s, t, y, y + s->n, dy + s->n, NULL);
    const struct mark mark = s->arena->top; /* effects take or give work that is integrated too */
    double *lambda = TAKE(s->arena, double, s->model->rows);
    enum outcome found = OUTCOME_NO_MEMORY;
    if (!s->arena->ran_out)
        found = accelerate(s, t, y, y + s->n, dy + s->n, lambda);
    if (!found)
        found = power_with(s, t, y, y + s->n, dy + s->n, lambda, dy + 2 * s->n);
    give_back(s->arena, mark);
    return found;
}

enum outcome system_derivative(struct system *s, double t, const double *y, double *dy)
{
    if (!s->branch)
        return derivative_at(s, t, y, dy);
    const size_t n = s->n;
    const struct mark mark = s->arena->top;
    double *projected = TAKE(s->arena, double, 2 * n);
    enum outcome outcome = OUTCOME_NO_MEMORY;
    if (s->arena->ran_out)
        goto end;
    memcpy(projected, y, 2 * n * sizeof *y);
    outcome = project_state(s, projected, projected + n);
    outcome = outcome ? outcome : derivative_at(s, t, projected, dy);
end:
    give_back(s->arena, mark);
    return outcome;
}
