/* Projection onto the closure: Gauss-Newton in the metric of the mass matrix (docs/theory, section 6).
 *
 * The correction M^-1 A^T (A M^-1 A^T)^-1 c is what the impulsive equations give for closure rates -c, so internal
 * impulses do it: linear and angular momentum stay as they are.
 */
#include "motion/projection.h"

#include <float.h>
#include <math.h>

#include "base/tolerances.h"
#include "constraints/onto_branch.h"
#include "constraints/impulse.h"
#include "constraints/nullspace.h"
#include "model/contacts.h"

enum { MAX_PASSES = 20 };

static double largest(int n, const double *x)
{
    double found = 0.0;
    for (int i = 0; i < n; i++)
        if (!(fabs(x[i]) <= found)) /* a NaN too */
            found = isnan(x[i]) ? INFINITY : fabs(x[i]);
    return found;
}

/* What a projection works with */
struct room {
    double *rows;          /* [rows + 2 contacts] what closure and held contacts miss, or the rates to take that away */
    double *jump;          /* [n] the correction */
    double *rates, *slips; /* [contacts] */
};

static enum outcome take_room(const struct system *s, struct room *r)
{
    const size_t contacts = s->model->contacts;
    r->rows = TAKE(s->arena, double, s->model->rows + 2 * contacts);
    r->jump = TAKE(s->arena, double, s->n);
    r->rates = TAKE(s->arena, double, contacts);
    r->slips = TAKE(s->arena, double, contacts);
    return s->arena->ran_out ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
}

/* gaps of the held contacts below the closure rows; the largest, angles as lengths */
static double held_gaps(const struct system *s, const double *q, struct room *r)
{
    const struct active_set *h = s->active;
    if (!active_count(s))
        return 0.0;
    double found = 0.0, *gaps = r->rates;
    contact_gaps(s, q, gaps);
    for (int i = 0; i < h->count; i++) {
        const int c = h->set[i];
        r->rows[s->model->rows + i] = gaps[c];
        found = fmax(found, isnan(gaps[c]) ? INFINITY : fabs(gaps[c]) * (s->length / s->extent[c]));
    }
    return found;
}

static enum outcome correct(struct system *s, const double *q, int speed, double nearest, struct room *r, double *x)
{
    for (int i = 0; i < s->model->rows + active_rows(s, speed); i++)
        r->rows[i] = -r->rows[i];
    const enum outcome outcome = system_correction(s, q, speed, r->rows, nearest, r->jump);
    for (int i = 0; i < s->n && !outcome; i++)
        x[i] += r->jump[i];
    return outcome;
}

static enum outcome close_gaps(struct system *s, struct room *r, double *q)
{
    const struct ccgen_model *m = s->model;
    const double unit = 2.0 * DBL_EPSILON * s->length; /* the last digit of an angle moves a link's end by that much */
    double angles = m->links, place = 0.0;
    for (int i = 0; i < s->n; i++) {
        angles += s->lengths[i] ? 0.0 : fabs(q[i]);
        place += s->lengths[i] ? 2.0 * DBL_EPSILON * fabs(q[i]) : 0.0;
    }
    const long dependent = s->rank_deficient;
    double before = INFINITY, nearest = RANK_TOLERANCE_PROJECTED;
    for (int pass = 0; pass < MAX_PASSES; pass++) {
        m->closure(s->k, q, r->rows);
        const double shut = largest(m->rows, r->rows), closed = held_gaps(s, q, r);
        const double miss = fmax(shut, closed);
        s->missed = pass ? s->missed : shut;
        const double enough = s->rank_deficient > dependent ? LEFT_OUT * s->length : 16.0 * (unit * angles + place);
        const int stagnant = miss <= enough && miss > 0.5 * before;
        if ((shut <= unit * m->links && closed <= unit * m->links + place) || stagnant)
            return OUTCOME_DONE;
        if (miss > 0.5 * before) /* a row that was left out has to be kept after all */
            nearest = fmax(LEFT_OUT_LATER * nearest, RANK_TOLERANCE);
        before = miss;
        if (interrupted(s->interruption, s->n))
            return OUTCOME_INTERRUPTED;
        const enum outcome outcome = isfinite(miss) ? correct(s, q, 0, nearest, r, q) : OUTCOME_NOT_FINITE;
        if (outcome)
            return outcome;
    }
    return OUTCOME_NOT_CLOSED;
}

enum outcome project_position(struct system *s, double *q)
{
    if (!s->rows_on && !active_count(s))
        return OUTCOME_DONE;
    const struct mark mark = s->arena->top;
    struct room room;
    enum outcome outcome = take_room(s, &room);
    outcome = outcome ? outcome : close_gaps(s, &room, q);
    give_back(s->arena, mark);
    return outcome;
}

enum outcome project_velocity(struct system *s, const double *q, double *u)
{
    const struct ccgen_model *m = s->model;
    if (!s->rows_on && !active_count(s))
        return OUTCOME_DONE;
    const struct mark mark = s->arena->top;
    struct room r;
    enum outcome outcome = take_room(s, &r);
    if (outcome)
        goto end;
    s->left_out = 0;
    m->closure_rate(s->k, q, u, r.rows);
    s->missed_rate = largest(m->rows, r.rows);
    if (active_count(s))
        rates_of_active(s, q, u, s->active->rows, r.rates, r.slips, r.rows + m->rows);
    outcome = correct(s, q, 1, RANK_TOLERANCE_PROJECTED, &r, u);
    s->moved_rate = outcome ? INFINITY : fastest(s, r.jump);
end:
    give_back(s->arena, mark);
    return outcome;
}

enum outcome project_state(struct system *s, double *q, double *u)
{
    if (follows_at(s, q))
        return put_onto_branch(s, q, u);
    const enum outcome outcome = project_position(s, q);
    return outcome ? outcome : project_velocity(s, q, u);
}
