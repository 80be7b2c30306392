/* The system's accelerations: the generated kernels with the forces of held contacts, or the null-space path where they lose rank. */
#include "motion/acceleration.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "algebra/elimination.h"
#include "base/tolerances.h"
#include "constraints/onto_branch.h"
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

/* What the robust path works with, where it has been taken at one state */
struct robust {
    struct nullspace motions;
    struct motion motion;
    double *forces;          /* [rows + held] */
    double *push, *friction; /* [contacts] zeros, [n] */
};

static enum outcome take_robust_path(struct system *s, double t, const double *q, const double *u, struct robust *r)
{
    const struct ccgen_model *m = s->model;
    const int held = active_rows(s, 1);
    double *bias = TAKE(s->arena, double, m->rows + held);
    double *rates = TAKE(s->arena, double, m->contacts), *slips = TAKE(s->arena, double, m->contacts);
    r->motion = (struct motion){u, t, NULL};
    r->forces = TAKE(s->arena, double, m->rows + held);
    r->push = TAKE_ZEROS(s->arena, double, m->contacts);
    r->friction = TAKE(s->arena, double, s->n);
    if (s->arena->ran_out)
        return OUTCOME_NO_MEMORY;
    bias_of_active(s, q, u, rates, slips, bias + m->rows);
    m->closure_bias(s->k, q, u, bias);
    for (int i = 0; i < m->rows + held; i++)
        bias[i] = -bias[i];
    return factorise_motions(s, q, held, bias, &t, RANK_TOLERANCE, &r->motions);
}

/* On the robust path, with the friction that the forces h->force bring where contacts slide; the forces that it finds in
 * h->force and, of those that slide, in slid[]. Returns how many slide. */
static int accelerate_with(struct system *s, struct robust *r, double *u_dot, double *slid)
{
    struct active_set *h = s->active;
    int sliding = 0;
    r->motion.friction = sliding_friction(s, r->motions.q, r->push, r->friction) ? r->friction : NULL;
    choose_motion(s, &r->motions, flight_residual, &r->motion, u_dot, r->forces);
    for (int i = 0; i < active_rows(s, 1); i++) {
        h->force[i] = r->forces[s->model->rows + i];
        if (i < h->count && against(h->mode[i]))
            slid[sliding++] = h->force[i];
    }
    return sliding;
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

/* Where rows of held contacts, of which all count with those of the closure but `counting`, leave forces open: those of least norm of the contacts, then multipliers of
 * least norm, as without dependent rows of the closure. 0, 2 where friction jams, or 1 where none is open, or digits are lost: all multipliers at once are then asked. */
static int accelerate_sharing(struct system *s, double t, const double *q, const double *u, int counting, double *u_dot,
                              double *lambda)
{
    const struct ccgen_model *m = s->model;
    const struct mark mark = s->arena->top;
    const struct motion motion = {u, t, NULL};
    double *bias = TAKE(s->arena, double, m->rows), *multipliers = TAKE(s->arena, double, m->rows);
    struct nullspace flight;
    int wrong = 1;
    if (s->arena->ran_out)
        goto end;
    m->closure_bias(s->k, q, u, bias);
    for (int i = 0; i < m->rows; i++)
        bias[i] = -bias[i];
    if (factorise_motions(s, q, 0, bias, &t, RANK_TOLERANCE, &flight) || flight.rank + active_rows(s, 1) <= counting)
        goto end;
    choose_motion(s, &flight, flight_residual, &motion, u_dot, multipliers);
    wrong = add_contact_accelerations_in_nullspace(s, q, u, &flight, u_dot, multipliers);
    if (!wrong && lambda)
        memcpy(lambda, multipliers, m->rows * sizeof *lambda);
end:
    give_back(s->arena, mark);
    return wrong;
}

/* On the robust path. The friction of contacts that slide follows from forces that it changes, p -> g + J p: J column by
 * column, then p = (1 - J)^-1 g, then once more for what rounding has lost. Where 1 - J has lost rank or its
 * determinant is negative, friction jams. Multipliers where lambda is not NULL. */
static enum outcome accelerate_in_nullspace(struct system *s, double t, const double *q, const double *u, double *u_dot,
                                            double *lambda)
{
    struct active_set *h = s->active;
    const size_t count = active_count(s);
    const struct mark mark = s->arena->top;
    struct robust robust;
    double *g = TAKE(s->arena, double, count), *p = TAKE_ZEROS(s->arena, double, count);
    double *found = TAKE(s->arena, double, count);
    double *J = TAKE(s->arena, double, (count * count)), *copy = TAKE(s->arena, double, (count * count));
    double scale = DBL_MIN;
    enum outcome outcome = s->arena->ran_out ? OUTCOME_NO_MEMORY : take_robust_path(s, t, q, u, &robust);
    if (outcome)
        goto end;
    const int open = count && robust.motions.rank < robust.motions.rows;
    const int shared = open ? accelerate_sharing(s, t, q, u, robust.motions.rank, u_dot, lambda) : 1;
    if (shared != 1) {
        outcome = shared ? OUTCOME_JAMMED : OUTCOME_DONE;
        goto end;
    }
    if (count)
        h->open = 0; /* what rates they give has no digits that would tell of others */
    if (count)
        set_trial_forces(h, NULL, -1, 0.0);
    const int k = accelerate_with(s, &robust, u_dot, g);
    for (int i = 0; i < k; i++)
        scale = fmax(scale, fabs(g[i]));
    for (int j = 0; j < k; j++) {
        set_trial_forces(h, NULL, j, scale);
        accelerate_with(s, &robust, u_dot, found);
        for (int i = 0; i < k; i++)
            J[i * k + j] = (i == j) - (found[i] - g[i]) / scale;
    }
    for (int pass = 0; k && pass <= REFINEMENTS; pass++) {
        memcpy(copy, J, (size_t)k * k * sizeof *J);
        if (eliminate(k, copy, g, SLIDING_PIVOT) <= 0) {
            outcome = OUTCOME_JAMMED;
            goto end;
        }
        for (int i = 0; i < k; i++)
            p[i] += g[i];
        set_trial_forces(h, p, -1, 1.0);
        accelerate_with(s, &robust, u_dot, g);
        for (int i = 0; i < k; i++)
            g[i] -= p[i];
    }
    if (lambda)
        memcpy(lambda, robust.forces, s->model->rows * sizeof *lambda);
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
    const int follows = follows_at(s, q);
    int dependent = follows ? 1 : m->acceleration(s->k, q, u, t, s->inputs, u_dot, lambda);
    if (!dependent &&
        active_count(s)) /* columns of the contacts would each lose digits: both together on the robust path */
        dependent = s->refine ? 1 : add_contact_accelerations(s, q, u, u_dot);
    if (dependent > 1)
        return OUTCOME_JAMMED;
    if (dependent)
        outcome = accelerate_in_nullspace(s, t, q, u, u_dot, lambda);
    else if (s->refine)
        outcome = refine_acceleration(s, t, q, u, u_dot, lambda);
    if (!outcome && s->baumgarte > 0.0 && s->rows_on && !follows &&
        !active_count(s)) /* held contacts are projected, and the loops with them */
        outcome = damp_drift(s, q, u, u_dot);
    for (int i = 0; i < s->n && !outcome; i++)
        if (!isfinite(u_dot[i]))
            outcome = OUTCOME_NOT_FINITE;
    return outcome;
}

/* At the state of the branch that belongs to this one */
static enum outcome accelerate_on_branch(struct system *s, double t, const double *q, const double *u, double *u_dot,
                                         double *lambda)
{
    const size_t n = s->n;
    const struct mark mark = s->arena->top;
    double *there = TAKE(s->arena, double, 2 * n);
    enum outcome outcome = s->arena->ran_out ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    if (!outcome) {
        memcpy(there, q, n * sizeof *q);
        memcpy(there + n, u, n * sizeof *u);
        outcome = put_onto_branch(s, there, there + n);
    }
    outcome = outcome ? outcome : accelerate(s, t, there, there + n, u_dot, lambda);
    give_back(s->arena, mark);
    return outcome;
}

enum outcome accelerate(struct system *s, double t, const double *q, const double *u, double *u_dot, double *lambda)
{
    if (follows_at(s, q) && !is_on_branch(s, q, u))
        return accelerate_on_branch(s, t, q, u, u_dot, lambda);
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
