/* The system's accelerations and velocity jumps: the generated kernels, or the robust path where they lose rank. */
#include "core.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "contact.h"
#include "elimination.h"
#include "refine.h"
#include "robust.h"

enum { REFINEMENTS = 1 };
/* a pivot of the forces of contacts that slide below that has lost its digits */
static const double SINGULAR = CCGEN_LIMIT(1e-12, 5e-6);

const double NEAREST = CCGEN_LIMIT(1e-10, 4e-5), NEAREST_PROJECTED = CCGEN_LIMIT(1e-5, 6e-3);

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

static void impact_residual(const struct system *s, const double *q, const void *context, const double *x, double *out)
{
    const double *f = context;
    s->model->momentum(s->k, q, x, out);
    for (int i = 0; i < s->n; i++)
        out[i] -= f[i];
}

static enum outcome supply(struct system *s, double t, const double *q, const double *u)
{
    if (!s->supply || !s->supply(s->context, t, q, u, s->inputs))
        return OUTCOME_DONE;
    if (s->interruption)
        s->interruption->ended = 1;
    return OUTCOME_INTERRUPTED;
}

/* Baumgarte's stabilisation: what is added to accelerations so that the closure c obeys c'' + 2 r c' + r^2 c = 0
 * (J. Baumgarte, Computer Methods in Applied Mechanics and Engineering 1, 1972) */
static enum outcome damp_drift(struct system *s, const double *q, const double *u, double *u_dot)
{
    const struct ccgen_model *m = s->model;
    const double r = s->baumgarte;
    m->closure_rate(s->k, q, u, s->rows);
    m->closure(s->k, q, s->bias);
    for (int i = 0; i < m->rows; i++)
        s->rows[i] = -2.0 * r * s->rows[i] - r * r * s->bias[i];
    const enum outcome outcome = system_impulse(s, q, s->zero, s->rows, NEAREST_PROJECTED, s->jump, s->bias);
    for (int i = 0; i < s->n && !outcome; i++)
        u_dot[i] += s->jump[i];
    return outcome;
}

/* Generalized forces f[n] of friction where held contacts slide, from their normal forces; returns whether any does. */
static int sliding_friction(struct system *s, const double *q, double *f)
{
    struct holding *h = s->holding;
    int any = 0;
    for (int i = 0; i < holds(s); i++)
        if (against(h->slide[i])) {
            h->pushes[h->set[i]] = -against(h->slide[i]) * s->friction[h->set[i]] * h->force[i];
            any = 1;
        }
    if (any)
        s->model->slip_impulse(s->k, q, h->pushes, f);
    for (int i = 0; i < holds(s); i++)
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
    const int held = held_bias(s, q, u, s->bias + m->rows);
    m->closure_bias(s->k, q, u, s->bias);
    for (int i = 0; i < m->rows + held; i++)
        s->bias[i] = -s->bias[i];
    if (sliding_friction(s, q, s->jump))
        motion.friction = s->jump;
    const enum outcome outcome = solve_dependent(s, q, held, s->bias, &t, NEAREST, flight_residual, &motion, u_dot, lambda);
    *sliding = 0;
    for (int i = 0; i < held && !outcome; i++) {
        s->holding->force[i] = lambda[m->rows + i];
        if (i < s->holding->count && against(s->holding->slide[i]))
            slid[(*sliding)++] = s->holding->force[i];
    }
    return outcome;
}

/* Set the forces of the contacts that slide, all scaled by `scale`, or but number `one` zero where `all` is not given. */
static void suppose(struct holding *h, const double *all, int one, double scale)
{
    for (int i = 0, k = 0; i < h->count; i++)
        if (against(h->slide[i])) {
            h->force[i] = all ? all[k] : k == one ? scale : 0.0;
            k++;
        }
}

/* On the robust path. The friction of contacts that slide follows from forces that it changes, p -> g + J p: J column by
 * column, then p = (1 - J)^-1 g, then once more for what rounding has lost. Where 1 - J has lost rank or its
 * determinant is negative, friction jams. */
static enum outcome accelerate_dependent(struct system *s, double t, const double *q, const double *u, double *u_dot,
                                         double *lambda)
{
    struct holding *h = s->holding;
    int sliding = 0, unused;
    if (holds(s))
        suppose(h, NULL, -1, 0.0);
    double *g = holds(s) ? h->wanted : s->zero, *J = holds(s) ? h->W : NULL, *p = holds(s) ? h->solved : NULL;
    enum outcome outcome = accelerate_with(s, t, q, u, u_dot, lambda, g, &sliding);
    if (outcome || !sliding)
        return outcome;
    const int k = sliding;
    double *found = p + k, scale = DBL_MIN, *copy = found + k;
    for (int i = 0; i < k; i++)
        scale = fmax(scale, fabs(g[i]));
    for (int j = 0; j < k && !outcome; j++) {
        suppose(h, NULL, j, scale);
        outcome = accelerate_with(s, t, q, u, u_dot, lambda, found, &unused);
        for (int i = 0; i < k; i++)
            J[i * k + j] = (i == j) - (found[i] - g[i]) / scale;
    }
    memset(p, 0, k * sizeof *p);
    for (int pass = 0; pass <= REFINEMENTS && !outcome; pass++) {
        memcpy(copy, J, (size_t)k * k * sizeof *J);
        if (eliminate(k, copy, g, SINGULAR) <= 0)
            return OUTCOME_JAMMED;
        for (int i = 0; i < k; i++)
            p[i] += g[i];
        suppose(h, p, -1, 1.0);
        outcome = accelerate_with(s, t, q, u, u_dot, lambda, g, &unused);
        for (int i = 0; i < k; i++)
            g[i] -= p[i];
    }
    return outcome;
}

/* with the inputs as they are; lambda is scratch unless it is asked for */
static enum outcome accelerate(struct system *s, double t, const double *q, const double *u, int asked, double *u_dot,
                               double *lambda)
{
    const struct ccgen_model *m = s->model;
    enum outcome outcome = OUTCOME_DONE;
    if (interrupted(s, s->n))
        return OUTCOME_INTERRUPTED;
    s->evaluations++;
    int dependent = m->acceleration(s->k, q, u, t, s->inputs, u_dot, asked || s->refine ? lambda : NULL);
    if (!dependent && holds(s)) /* columns of the contacts would each lose digits: both together on the robust path */
        dependent = s->refine ? 1 : hold_acceleration(s, q, u, u_dot);
    if (dependent > 1)
        return OUTCOME_JAMMED;
    if (dependent)
        outcome = accelerate_dependent(s, t, q, u, u_dot, lambda);
    else if (s->refine)
        outcome = refine_acceleration(s, t, q, u, u_dot, lambda);
    if (!outcome && s->baumgarte > 0.0 && m->rows && !holds(s)) /* held contacts are projected, and the loops with them */
        outcome = damp_drift(s, q, u, u_dot);
    for (int i = 0; i < s->n && !outcome; i++)
        if (!isfinite(u_dot[i]))
            outcome = OUTCOME_NOT_FINITE;
    return outcome;
}

enum outcome system_acceleration(struct system *s, double t, const double *q, const double *u, double *u_dot,
                                 double *lambda)
{
    const enum outcome outcome = supply(s, t, q, u);
    return outcome ? outcome : accelerate(s, t, q, u, 1, u_dot, lambda);
}

enum outcome system_impulse(struct system *s, const double *q, const double *f, const double *y, double nearest,
                            double *du, double *Lambda)
{
    if (!s->model->impulse(s->k, q, f, y, du, Lambda))
        return s->refine ? refine_impulse(s, q, f, y, du, Lambda) : OUTCOME_DONE;
    return solve_dependent(s, q, 0, y, NULL, nearest, impact_residual, f, du, Lambda);
}

enum outcome system_correction(struct system *s, const double *q, int speed, double *rows, double nearest, double *du)
{
    const struct ccgen_model *m = s->model;
    int dependent = m->impulse(s->k, q, s->zero, rows, du, NULL);
    if (!dependent && holds(s))
        dependent = s->refine || hold_jump(s, q, speed, rows + m->rows, du);
    if (!dependent)
        return OUTCOME_DONE;
    return solve_dependent(s, q, held_rows(s, speed), rows, NULL, nearest, impact_residual, s->zero, du, s->multipliers);
}

/* Power (W) of the friction of held contacts that slide */
static double friction_power(struct system *s, const double *q, const double *u)
{
    struct holding *h = s->holding;
    double power = 0.0;
    if (holds(s))
        s->model->slips(s->k, q, u, h->slips);
    for (int i = 0; i < holds(s); i++)
        if (against(h->slide[i]))
            power -= against(h->slide[i]) * s->friction[h->set[i]] * h->force[i] * h->slips[h->set[i]];
    return power;
}

/* Power (W) of the effects that have no potential while contacts are held and joints are driven, with the accelerations
 * u_dot of the state. The kernel knows what drives take where no contact pushes; what contacts change, all of it by work of
 * the drives and of friction, changes the accelerations: u . M (u_dot - u_dot without contacts). */
static enum outcome driven_power(struct system *s, double t, const double *q, const double *u, const double *u_dot,
                                 double *power)
{
    const struct ccgen_model *m = s->model;
    struct holding *h = s->holding;
    double *apart = s->u_dot + s->n, *pushed = apart + s->n;
    const int count = h->count, rows = h->rows;
    h->count = h->rows = 0;
    const enum outcome outcome = accelerate(s, t, q, u, 1, apart, s->multipliers);
    h->count = count;
    h->rows = rows;
    if (outcome)
        return outcome;
    m->power(s->k, q, u, t, s->inputs, apart, s->multipliers, power);
    for (int i = 0; i < s->n; i++)
        apart[i] = u_dot[i] - apart[i];
    m->momentum(s->k, q, apart, pushed);
    for (int i = 0; i < s->n; i++)
        *power += u[i] * pushed[i];
    return OUTCOME_DONE;
}

/* Of the effects that have no potential and of friction in contacts, with the u_dot[n], lambda[rows] and forces of the state */
static enum outcome power_with(struct system *s, double t, const double *q, const double *u, const double *u_dot,
                               const double *lambda, double *power)
{
    const struct ccgen_model *m = s->model;
    *power = 0.0;
    if (m->drives && holds(s))
        return driven_power(s, t, q, u, u_dot, power);
    if (m->power)
        m->power(s->k, q, u, t, s->inputs, u_dot, lambda, power);
    if (s->friction)
        *power += friction_power(s, q, u);
    return OUTCOME_DONE;
}

enum outcome system_power(struct system *s, double t, const double *q, const double *u, double *power)
{
    enum outcome outcome = supply(s, t, q, u);
    if (!outcome && (s->model->drives || (s->friction && holds(s))))
        outcome = accelerate(s, t, q, u, 1, s->u_dot, s->multipliers);
    return outcome ? outcome : power_with(s, t, q, u, s->u_dot, s->multipliers, power);
}

enum outcome system_derivative(struct system *s, double t, const double *y, double *dy)
{
    enum outcome outcome = OUTCOME_DONE;
    if (s->guided) {
        memcpy(s->shut, y, 2 * s->n * sizeof *y);
        y = s->shut;
        outcome = project_position(s, s->shut);
        outcome = outcome ? outcome : project_velocity(s, s->shut, s->shut + s->n);
    }
    outcome = outcome ? outcome : supply(s, t, y, y + s->n);
    if (outcome)
        return outcome;
    memcpy(dy, y + s->n, s->n * sizeof *dy);
    const int powered = s->size > 2 * s->n; /* effects take or give work that is integrated too */
    const enum outcome found = accelerate(s, t, y, y + s->n, powered, dy + s->n, s->multipliers);
    if (found || !powered)
        return found;
    return power_with(s, t, y, y + s->n, dy + s->n, s->multipliers, dy + 2 * s->n);
}
