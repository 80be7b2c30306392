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
    m->closure_rate(s->k, q, u, s->rows);
    m->closure(s->k, q, s->bias);
    for (int i = 0; i < m->rows; i++)
        s->rows[i] = -2.0 * r * s->rows[i] - r * r * s->bias[i];
    const enum outcome outcome = system_impulse(s, q, s->zero, s->rows, RANK_TOLERANCE_PROJECTED, s->jump, s->bias);
    for (int i = 0; i < s->n && !outcome; i++)
        u_dot[i] += s->jump[i];
    return outcome;
}

/* Generalized forces f[n] of friction where held contacts slide, from their normal forces; returns whether any does. */
static int sliding_friction(struct system *s, const double *q, double *f)
{
    struct active_set *h = s->active;
    int any = 0;
    for (int i = 0; i < active_count(s); i++)
        if (against(h->mode[i])) {
            h->pushes[h->set[i]] = -against(h->mode[i]) * s->friction[h->set[i]] * h->force[i];
            any = 1;
        }
    if (any)
        s->model->slip_impulse(s->k, q, h->pushes, f);
    for (int i = 0; i < active_count(s); i++)
        h->pushes[h->set[i]] = 0.0;
    return any;
}

/* On the robust path, with the friction that the forces h->force bring where contacts slide; the forces that it finds in
 * h->force and, of those that slide, in slid[]. Returns how many slide in *sliding. */
static enum outcome accelerate_with(struct system *s, double t, const double *q, const double *u, double *u_dot,
                                    double *lambda, double *slid, int *sliding)
{
    const struct ccgen_model *m = s->model;
    struct motion motion = {u, t, NULL};
    const int held = active_bias(s, q, u, s->bias + m->rows);
    m->closure_bias(s->k, q, u, s->bias);
    for (int i = 0; i < m->rows + held; i++)
        s->bias[i] = -s->bias[i];
    if (sliding_friction(s, q, s->jump))
        motion.friction = s->jump;
    const enum outcome outcome =
        solve_in_nullspace(s, q, held, s->bias, &t, RANK_TOLERANCE, flight_residual, &motion, u_dot, lambda);
    *sliding = 0;
    for (int i = 0; i < held && !outcome; i++) {
        s->active->force[i] = lambda[m->rows + i];
        if (i < s->active->count && against(s->active->mode[i]))
            slid[(*sliding)++] = s->active->force[i];
    }
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
    int sliding = 0, unused;
    if (active_count(s))
        set_trial_forces(h, NULL, -1, 0.0);
    double *g = active_count(s) ? h->wanted : s->zero, *J = active_count(s) ? h->W : NULL,
           *p = active_count(s) ? h->solved : NULL;
    enum outcome outcome = accelerate_with(s, t, q, u, u_dot, lambda, g, &sliding);
    if (outcome || !sliding)
        return outcome;
    const int k = sliding;
    double *found = p + k, scale = DBL_MIN, *copy = found + k;
    for (int i = 0; i < k; i++)
        scale = fmax(scale, fabs(g[i]));
    for (int j = 0; j < k && !outcome; j++) {
        set_trial_forces(h, NULL, j, scale);
        outcome = accelerate_with(s, t, q, u, u_dot, lambda, found, &unused);
        for (int i = 0; i < k; i++)
            J[i * k + j] = (i == j) - (found[i] - g[i]) / scale;
    }
    memset(p, 0, k * sizeof *p);
    for (int pass = 0; pass <= REFINEMENTS && !outcome; pass++) {
        memcpy(copy, J, (size_t)k * k * sizeof *J);
        if (eliminate(k, copy, g, SLIDING_PIVOT) <= 0)
            return OUTCOME_JAMMED;
        for (int i = 0; i < k; i++)
            p[i] += g[i];
        set_trial_forces(h, p, -1, 1.0);
        outcome = accelerate_with(s, t, q, u, u_dot, lambda, g, &unused);
        for (int i = 0; i < k; i++)
            g[i] -= p[i];
    }
    return outcome;
}

enum outcome accelerate(struct system *s, double t, const double *q, const double *u, int asked, double *u_dot,
                        double *lambda)
{
    const struct ccgen_model *m = s->model;
    enum outcome outcome = OUTCOME_DONE;
    if (interrupted(s->interruption, s->n))
        return OUTCOME_INTERRUPTED;
    s->evaluations++;
    int dependent = m->acceleration(s->k, q, u, t, s->inputs, u_dot, asked || s->refine ? lambda : NULL);
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

enum outcome system_acceleration(struct system *s, double t, const double *q, const double *u, double *u_dot,
                                 double *lambda)
{
    const enum outcome outcome = supply_inputs(s, t, q, u);
    return outcome ? outcome : accelerate(s, t, q, u, 1, u_dot, lambda);
}
