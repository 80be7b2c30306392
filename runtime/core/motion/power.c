/* Power of effects that have no potential, of driven joints and of friction in contacts. */
#include "motion/power.h"

#include "constraints/branch.h"
#include "model/inputs.h"
#include "motion/acceleration.h"

/* Power (W) of the friction of held contacts, some of which slide; slips[contacts] is scratch. */
static double friction_power(const struct system *s, const double *q, const double *u, double *slips)
{
    const struct active_set *h = s->active;
    double power = 0.0;
    s->model->slips(s->k, q, u, slips);
    for (int i = 0; i < active_count(s); i++)
        if (against(h->mode[i]))
            power -= against(h->mode[i]) * s->friction[h->set[i]] * h->force[i] * slips[h->set[i]];
    return power;
}

/* Power (W) of the effects that have no potential while contacts are held and joints are driven, with the accelerations
 * u_dot of the state. The kernel knows what drives take where no contact pushes; what contacts change, all of it by work of
 * the drives and of friction, changes the accelerations: u . M (u_dot - u_dot without contacts). */
static enum outcome driven_power(struct system *s, double t, const double *q, const double *u, const double *u_dot,
                                 double *power)
{
    const struct ccgen_model *m = s->model;
    struct active_set *h = s->active;
    const struct mark mark = s->arena->top;
    double *apart = TAKE(s->arena, double, s->n), *pushed = TAKE(s->arena, double, s->n);
    double *lambda = TAKE(s->arena, double, m->rows);
    enum outcome outcome = OUTCOME_NO_MEMORY;
    if (s->arena->ran_out)
        goto end;
    const int count = h->count, rows = h->rows;
    h->count = h->rows = 0;
    outcome = accelerate(s, t, q, u, apart, lambda);
    h->count = count;
    h->rows = rows;
    if (outcome)
        goto end;
    m->power(s->k, q, u, t, s->inputs, apart, lambda, power);
    for (int i = 0; i < s->n; i++)
        apart[i] = u_dot[i] - apart[i];
    m->momentum(s->k, q, apart, pushed);
    for (int i = 0; i < s->n; i++)
        *power += u[i] * pushed[i];
end:
    give_back(s->arena, mark);
    return outcome;
}

/* The same along the system's branch, where multipliers of the closure may have no bound, and do no work. Of what moves it, f = M u_dot + h, all but
 * that is done by driven joints and by friction: u . f. The kernel has, without multipliers, the loads that driven joints would carry then: those of an open chain, each with
 * what the driven joints that turn on its link carry. */
static enum outcome power_along_branch(struct system *s, double t, const double *q, const double *u,
                                       const double *u_dot, double *power)
{
    const struct ccgen_model *m = s->model;
    const struct mark mark = s->arena->top;
    double *none = TAKE_ZEROS(s->arena, double, m->rows), *f = TAKE(s->arena, double, s->n);
    double *load = TAKE(s->arena, double, m->drives);
    const enum outcome outcome = s->arena->ran_out ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    *power = 0.0;
    if (outcome)
        goto end;
    if (m->power)
        m->power(s->k, q, u, t, s->inputs, u_dot, none, power);
    m->inverse_dynamics(s->k, q, u, t, s->inputs, u_dot, f);
    for (int i = 0; i < s->n; i++)
        *power += u[i] * f[i];
    for (int d = 0; d < m->drives; d++)
        load[d] = f[m->driven[2 * d]];
    for (int pass = 1; pass < m->drives; pass++) /* chains of driven joints are no longer than they are many */
        for (int d = 0; d < m->drives; d++) {
            load[d] = f[m->driven[2 * d]];
            for (int e = 0; e < m->drives; e++)
                load[d] += e != d && m->driven[2 * e + 1] == m->driven[2 * d] ? load[e] : 0.0;
        }
    for (int d = 0; d < m->drives; d++) {
        const int second = m->driven[2 * d + 1];
        *power -= load[d] * (u[m->driven[2 * d]] - (second < 0 ? 0.0 : u[second]));
    }
end:
    give_back(s->arena, mark);
    return outcome;
}

enum outcome power_with(struct system *s, double t, const double *q, const double *u, const double *u_dot,
                        const double *lambda, double *power)
{
    const struct ccgen_model *m = s->model;
    *power = 0.0;
    if (follows_at(s, q))
        return power_along_branch(s, t, q, u, u_dot, power);
    if (m->drives && active_count(s))
        return driven_power(s, t, q, u, u_dot, power);
    if (m->power)
        m->power(s->k, q, u, t, s->inputs, u_dot, lambda, power);
    if (!s->friction || !any_slides(s))
        return OUTCOME_DONE;
    const struct mark mark = s->arena->top;
    double *slips = TAKE(s->arena, double, m->contacts);
    const enum outcome outcome = s->arena->ran_out ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    if (!outcome)
        *power += friction_power(s, q, u, slips);
    give_back(s->arena, mark);
    return outcome;
}

enum outcome system_power(struct system *s, double t, const double *q, const double *u, double *power)
{
    const struct mark mark = s->arena->top;
    double *u_dot = TAKE(s->arena, double, s->n), *lambda = TAKE(s->arena, double, s->model->rows);
    enum outcome outcome = s->arena->ran_out ? OUTCOME_NO_MEMORY : supply_inputs(s, t, q, u);
    if (!outcome && (s->model->drives || (s->friction && active_count(s))))
        outcome = accelerate(s, t, q, u, u_dot, lambda);
    if (!outcome)
        outcome = power_with(s, t, q, u, u_dot, lambda, power);
    give_back(s->arena, mark);
    return outcome;
}
