/* The scales of a mechanism; see scales.h. */
#include "model/scales.h"

#include <math.h>
#include <string.h>

#include "algebra/power_of_two.h"

static const double HALF_TURN = 3.14159265358979323846;

void set_units(struct system *s)
{
    for (int i = 0; i < s->n; i++) {
        s->unit[i] = s->lengths[i] ? s->length : 1.0;
        s->unit[s->n + i] = s->unit[i] / s->time;
    }
    s->unit[2 * s->n] = s->energy;
}

/* Kinetic energy (J) of the coordinate that has the most at a speed of its unit, all others at rest */
static double heaviest(struct system *s, const double *q)
{
    const int n = s->n;
    double *speed = s->jump, *momentum = s->u_dot, found = 0.0;
    memset(speed, 0, n * sizeof *speed);
    for (int i = 0; i < n; i++) {
        speed[i] = s->unit[n + i];
        s->model->momentum(s->k, q, speed, momentum);
        found = fmax(found, 0.5 * momentum[i] * speed[i]);
        speed[i] = 0.0;
    }
    return found;
}

void set_scales(struct system *s, double longest, double rate, const double *q)
{
    s->time = nearest_power_of_two(rate * longest > HALF_TURN ? HALF_TURN / rate : longest);
    s->energy = 1.0;
    set_units(s);
    const double found = s->size > 2 * s->n ? heaviest(s, q) : 0.0;
    s->energy = found > 0.0 && isfinite(found) ? found : 1.0;
    s->unit[2 * s->n] = s->energy;
}
