/* The scales of a mechanism; see scales.h. */
#include "model/scales.h"

#include <math.h>

#include "base/tolerances.h"

static const double HALF_TURN = 3.14159265358979323846;

void set_units(struct system *s)
{
    for (int i = 0; i < s->n; i++) {
        s->unit[i] = s->lengths[i] ? s->length : 1.0;
        s->unit[s->n + i] = s->unit[i] / s->time;
    }
    s->unit[2 * s->n] = s->energy;
}

double heaviest(struct system *s, const double *q)
{
    const struct mark mark = s->arena->top;
    const int n = s->n;
    double *speed = TAKE_ZEROS(s->arena, double, n), *momentum = TAKE(s->arena, double, n);
    double found = s->arena->ran_out ? -1.0 : 0.0;
    for (int i = 0; i < n && found >= 0.0; i++) {
        speed[i] = s->unit[n + i];
        s->model->momentum(s->k, q, speed, momentum);
        found = fmax(found, 0.5 * momentum[i] * speed[i]);
        speed[i] = 0.0;
    }
    give_back(s->arena, mark);
    return found;
}

enum outcome set_scales(struct system *s, double longest, double rate, const double *q)
{
    s->time = rate * longest > HALF_TURN ? HALF_TURN / rate : longest;
    s->energy = 1.0;
    set_units(s);
    const double found = s->size > 2 * s->n ? heaviest(s, q) : 0.0;
    s->energy = found > 0.0 && isfinite(found) ? found : 1.0;
    s->unit[2 * s->n] = s->energy;
    return found < 0.0 ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
}

int turned_far(const struct system *s, const double *q)
{
    for (int i = 0; i < s->n; i++)
        if (!s->lengths[i] && fabs(q[i]) > ANGLE_KNOWN / DBL_EPSILON)
            return 1;
    return 0;
}
