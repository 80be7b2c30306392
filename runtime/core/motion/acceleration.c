/* The system's accelerations: the generated kernels with the forces of held contacts, or the null-space path where they lose rank. */
#include "motion/acceleration.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "algebra/elimination.h"
#include "base/tolerances.h"
#include "constraints/contact_forces.h"
#include "constraints/impulse.h"
#include "constraints/nullspace.h"
#include "constraints/refinement.h"
#include "model/inputs.h"

enum { REFINEMENTS = 1 };

struct motion {
    const double *u;
    double t;
    const double *friction; /* [n] generalized forces of contacts that slide, or NULL */
};

static void flight_residual(const struct system *s, const double *q, const void *context, const double *x, double *out)
{
    const struct motion *motion = context;
    s->model->inverse_dynamics(s->k, q, motion->u, motion->t, s->inputs, x, out);
    for (int i = 0; motion->friction && i < s->n; i++)
        out[i] -= motion->friction[i];
}

/* Baumgarte's stabilisation: what is added to accelerations so that the closure c obeys c'' + 2 r c' + r^2 c = 0
 * (J. Baumgarte, Computer Methods in Applied Mechanics and Engineering 1, 1972) */
static enum outcome damp_drift(struct system *s, const double *q, const double *u, double *u_dot)
{
    const struct ccgen_model *m = s->model;
    const double r = s->baumgarte / s->time;
    const struct mark mark = s->arena->top;
    double *gaps = TAKE(s->arena, double, m->rows), *rates = TAKE(s->arena, double, m->rows);
    double *multipliers = TAKE(s->arena, double, m->rows);
    double *none = TAKE_ZEROS(s->arena, double, s->n), *more = TAKE(s->arena, double, s->n);
    enum outcome outcome = OUTCOME_NO_MEMORY;
    if (s->arena->ran_out)
        goto end;
    m->closure_rate(s->k, q, u, rates);
    m->closure(s->k, q, gaps);
    for (int i = 0; i < m->rows; i++)
        rates[i] = -2.0 * r * rates[i] - r * r * gaps[i];
    outcome = system_impulse(s, q, none, rates, RANK_TOLERANCE_PROJECTED, more, multipliers);
    for (int i = 0; i < s->n && !outcome; i++)
        u_dot[i] += more[i];
end:
    give_back(s->arena, mark);
    return outcome;
}

/* Generalized forces f[n] of friction where held contacts slide, from their normal forces; returns whether any does. push[contacts]
 * are zeros. */
static int sliding_friction(const struct system *s, const double *q, double *push, double *f)
{
    const struct active_set *h = s->active;
    int any = 0;
    for (int i = 0; i < active_count(s); i++)
        if (against(h->mode[i])) {
            push[h->set[i]] = -against(h->mode[i]) * s->friction[h->set[i]] * h->force[i];
            any = 1;
        }
    if (any)
        s->model->slip_impulse(s->k, q, push, f);
    return any;
}

/* On the robust path, with the friction that the forces h->force bring where contacts slide; the forces that it finds in
 * h->force and, of those that slide, in slid[]. Returns how many slide in *sliding. Multipliers where lambda is not NULL. */
static enum outcome accelerate_with(struct system *s, double t, const double *q, const double *u, double *u_dot,
                                    double *lambda, double *slid, int *sliding)
{
    const struct ccgen_model *m = s->model;
    const int held = active_rows(s, 1);
    struct motion motion = {u, t, NULL};
    const struct mark mark = s->arena->top;
    double *bias = TAKE(s->arena, double, m->rows + held), *forces = TAKE(s->arena, double, m->rows + held);
    double *rates = TAKE(s->arena, double, m->contacts), *slips = TAKE(s->arena, double, m->contacts);
    double *push = TAKE_ZEROS(s->arena, double, m->contacts), *friction = TAKE(s->arena, double, s->n);
    enum outcome outcome = OUTCOME_NO_MEMORY;
    *sliding = 0;
    if (s->arena->ran_out)
        goto end;
    bias_of_active(s, q, u, rates, slips, bias + m->rows);
    m->closure_bias(s->k, q, u, bias);
    for (int i = 0; i < m->rows + held; i++)
        bias[i] = -bias[i];
    if (sliding_friction(s, q, push, friction))
        motion.friction = friction;
    outcome = solve_in_nullspace(s, q, held, bias, &t, RANK_TOLERANCE, flight_residual, &motion, u_dot, forces);
    for (int i = 0; i < held && !outcome; i++) {
        s->active->force[i] = forces[m->rows + i];
        if (i < s->active->count && against(s->active->mode[i]))
            slid[(*sliding)++] = s->active->force[i];
    }
    if (lambda && !outcome)
        memcpy(lambda, forces, m->rows * sizeof *lambda);
end:
    give_back(s->arena, mark);
    return outcome;
}

/* Set the forces of the contacts that slide, all scaled by `scale`, or but number `one` zero where `all` is not given. */
static void set_trial_forces(struct active_set *h, const double *all, int one, double scale)
{
    for (int i = 0, k = 0; i < h->count; i++)
        if (against(h->mode[i])) {
            h->force[i] = all ? all[k] : k == one ? scale : 0.0;
            k++;
        }
}

/* On the robust path. The friction of contacts that slide follows from forces that it changes, p -> g + J p: J column by
 * column, then p = (1 - J)^-1 g, then once more for what rounding has lost. Where 1 - J has lost rank or its
 * determinant is negative, friction jams. */
static enum outcome accelerate_in_nullspace(struct system *s, double t, const double *q, const double *u, double *u_dot,
                                            double *lambda)
{
    struct active_set *h = s->active;
    const size_t count = active_count(s);
    const struct mark mark = s->arena->top;
    double *g = TAKE(s->arena, double, count), *p = TAKE_ZEROS(s->arena, double, count);
    double *found = TAKE(s->arena, double, count);
    double *J = TAKE(s->arena, double, (count * count)), *copy = TAKE(s->arena, double, (count * count));
    enum outcome outcome = OUTCOME_NO_MEMORY;
    int k = 0, unused;
    double scale = DBL_MIN;
    if (s->arena->ran_out)
        goto end;
    if (count)
        set_trial_forces(h, NULL, -1, 0.0);
    outcome = accelerate_with(s, t, q, u, u_dot, lambda, g, &k);
    if (outcome || !k)
        goto end;
    for (int i = 0; i < k; i++)
        scale = fmax(scale, fabs(g[i]));
    for (int j = 0; j < k && !outcome; j++) {
        set_trial_forces(h, NULL, j, scale);
        outcome = accelerate_with(s, t, q, u, u_dot, lambda, found, &unused);
        for (int i = 0; i < k; i++)
            J[i * k + j] = (i == j) - (found[i] - g[i]) / scale;
    }
    for (int pass = 0; pass <= REFINEMENTS && !outcome; pass++) {
        memcpy(copy, J, (size_t)k * k * sizeof *J);
        if (eliminate(k, copy, g, SLIDING_PIVOT) <= 0) {
            outcome = OUTCOME_JAMMED;
            goto end;
        }
        for (int i = 0; i < k; i++)
            p[i] += g[i];
        set_trial_forces(h, p, -1, 1.0);
        outcome = accelerate_with(s, t, q, u, u_dot, lambda, g, &unused);
        for (int i = 0; i < k; i++)
            g[i] -= p[i];
    }
end:
    give_back(s->arena, mark);
    return outcome;
}

/* Multipliers where lambda is not NULL, which refinement needs */
static enum outcome solve_motion(struct system *s, double t, const double *q, const double *u, double *u_dot,
                                 double *lambda)
{
    const struct ccgen_model *m = s->model;
    enum outcome outcome = OUTCOME_DONE;
    if (interrupted(s->interruption, s->n))
        return OUTCOME_INTERRUPTED;
    s->evaluations++;
    int dependent = m->acceleration(s->k, q, u, t, s->inputs, u_dot, lambda);
    if (!dependent &&
        active_count(s)) /* columns of the contacts would each lose digits: both together on the robust path */
        dependent = s->refine ? 1 : add_contact_accelerations(s, q, u, u_dot);
    if (dependent > 1)
        return OUTCOME_JAMMED;
    if (dependent)
        outcome = accelerate_in_nullspace(s, t, q, u, u_dot, lambda);
    else if (s->refine)
        outcome = refine_acceleration(s, t, q, u, u_dot, lambda);
    if (!outcome && s->baumgarte > 0.0 && m->rows &&
        !active_count(s)) /* held contacts are projected, and the loops with them */
        outcome = damp_drift(s, q, u, u_dot);
    for (int i = 0; i < s->n && !outcome; i++)
        if (!isfinite(u_dot[i]))
            outcome = OUTCOME_NOT_FINITE;
    return outcome;
}

enum outcome accelerate(struct system *s, double t, const double *q, const double *u, double *u_dot, double *lambda)
{
    if (lambda || !s->refine)
        return solve_motion(s, t, q, u, u_dot, lambda);
    const struct mark mark = s->arena->top;
    lambda = TAKE(s->arena, double, s->model->rows);
    const enum outcome outcome = s->arena->ran_out ? OUTCOME_NO_MEMORY : solve_motion(s, t, q, u, u_dot, lambda);
    give_back(s->arena, mark);
    return outcome;
}

enum outcome system_acceleration(struct system *s, double t, const double *q, const double *u, double *u_dot,
                                 double *lambda)
{
    const enum outcome outcome = supply_inputs(s, t, q, u);
    return outcome ? outcome : accelerate(s, t, q, u, u_dot, lambda);
}
