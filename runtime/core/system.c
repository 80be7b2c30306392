/* The system's accelerations and velocity jumps: the generated kernels, or the robust path where they lose rank. */
#include "core.h"

#include <math.h>
#include <string.h>

#include "robust.h"

const double NEAREST = 1e-10, NEAREST_PROJECTED = 1e-3;

struct motion {
    const double *u;
    double t;
};

static void flight_residual(const struct system *s, const double *q, const void *context, const double *x, double *out)
{
    const struct motion *motion = context;
    s->model->inverse_dynamics(s->k, q, motion->u, motion->t, s->inputs, x, out);
}

static void impact_residual(const struct system *s, const double *q, const void *context, const double *x, double *out)
{
    const double *f = context;
    s->model->momentum(s->k, q, x, out);
    for (int i = 0; i < s->n; i++)
        out[i] -= f[i];
}

static enum outcome supply(struct system *s, double t, const double *q, const double *u)
{
    return s->supply && s->supply(s->context, t, q, u, s->inputs) ? OUTCOME_INTERRUPTED : OUTCOME_DONE;
}

/* with the inputs as they are */
static enum outcome accelerate(struct system *s, double t, const double *q, const double *u, double *u_dot, double *lambda)
{
    const struct ccgen_model *m = s->model;
    enum outcome outcome = OUTCOME_DONE;
    s->evaluations++;
    if (m->acceleration(s->k, q, u, t, s->inputs, u_dot, lambda)) {
        const struct motion motion = {u, t};
        s->dependent++;
        m->closure_bias(s->k, q, u, s->bias);
        for (int i = 0; i < m->rows; i++)
            s->bias[i] = -s->bias[i];
        outcome = solve_dependent(s, q, s->bias, &t, NEAREST, flight_residual, &motion, u_dot, lambda);
    }
    for (int i = 0; i < s->n && !outcome; i++)
        if (!isfinite(u_dot[i]))
            outcome = OUTCOME_NOT_FINITE;
    return outcome;
}

enum outcome system_acceleration(struct system *s, double t, const double *q, const double *u, double *u_dot,
                                 double *lambda)
{
    const enum outcome outcome = supply(s, t, q, u);
    return outcome ? outcome : accelerate(s, t, q, u, u_dot, lambda);
}

enum outcome system_impulse(struct system *s, const double *q, const double *f, const double *y, double nearest,
                            double *du, double *Lambda)
{
    if (!s->model->impulse(s->k, q, f, y, du, Lambda))
        return OUTCOME_DONE;
    s->dependent++;
    return solve_dependent(s, q, y, NULL, nearest, impact_residual, f, du, Lambda);
}

enum outcome system_derivative(struct system *s, double t, const double *y, double *dy)
{
    const enum outcome outcome = supply(s, t, y, y + s->n);
    if (outcome)
        return outcome;
    memcpy(dy, y + s->n, s->n * sizeof *dy);
    const enum outcome solved = accelerate(s, t, y, y + s->n, dy + s->n, s->multipliers);
    if (s->model->power && !solved)
        s->model->power(s->k, y, y + s->n, t, s->inputs, dy + s->n, s->multipliers, dy + 2 * s->n);
    return solved;
}
