/* The right-hand side: velocities, accelerations, and power where the system has an entry of work. */
#include "motion/derivative.h"

#include <string.h>

#include "model/inputs.h"
#include "motion/acceleration.h"
#include "motion/power.h"
#include "motion/projection.h"

enum outcome system_derivative(struct system *s, double t, const double *y, double *dy)
{
    enum outcome outcome = OUTCOME_DONE;
    if (s->projects_stages) {
        memcpy(s->projected, y, 2 * s->n * sizeof *y);
        y = s->projected;
        outcome = project_position(s, s->projected);
        outcome = outcome ? outcome : project_velocity(s, s->projected, s->projected + s->n);
    }
    outcome = outcome ? outcome : supply_inputs(s, t, y, y + s->n);
    if (outcome)
        return outcome;
    memcpy(dy, y + s->n, s->n * sizeof *dy);
    const int powered = s->size > 2 * s->n; /* effects take or give work that is integrated too */
    const enum outcome found = accelerate(s, t, y, y + s->n, powered, dy + s->n, s->multipliers);
    if (found || !powered)
        return found;
    return power_with(s, t, y, y + s->n, dy + s->n, s->multipliers, dy + 2 * s->n);
}
