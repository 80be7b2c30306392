/* Projection onto the closure: Gauss-Newton in the metric of the mass matrix (docs/theory, section 6).
 *
 * The correction M^-1 A^T (A M^-1 A^T)^-1 c is what the impulsive equations give for closure rates -c, so internal
 * impulses do it: linear and angular momentum stay as they are.
 */
#include "motion/projection.h"

#include <float.h>
#include <math.h>

#include "base/tolerances.h"
#include "constraints/impulse.h"
#include "constraints/nullspace.h"

enum { MAX_PASSES = 20 };

static double largest(int n, const double *x)
{
    double found = 0.0;
    for (int i = 0; i < n; i++)
        found = fmax(found, isnan(x[i]) ? INFINITY : fabs(x[i]));
    return found;
}

/* gaps of the held contacts below the closure rows; the largest, angles as lengths */
static double held_gaps(struct system *s, const double *q)
{
    struct active_set *h = s->active;
    if (!active_count(s))
        return 0.0;
    s->model->gaps(s->k, q, h->rates);
    double found = 0.0;
    for (int i = 0; i < h->count; i++) {
        const int c = h->set[i];
        s->rows[s->model->rows + i] = h->rates[c];
        found = fmax(found, isnan(h->rates[c]) ? INFINITY : fabs(h->rates[c]) * (s->length / s->extent[c]));
    }
    return found;
}

/* rates of the held contacts, and sliding of those that stick, below the closure rows */
static void held_speeds(struct system *s, const double *q, const double *u)
{
    struct active_set *h = s->active;
    s->model->gap_rates(s->k, q, u, h->rates);
    if (h->rows > h->count)
        s->model->slips(s->k, q, u, h->slips);
    for (int i = 0; i < h->rows; i++)
        s->rows[s->model->rows + i] = (i < h->count ? h->rates : h->slips)[h->set[h->of[i]]];
}

static enum outcome correct(struct system *s, const double *q, int speed, double nearest, double *x)
{
    for (int i = 0; i < s->model->rows + active_rows(s, speed); i++)
        s->rows[i] = -s->rows[i];
    const enum outcome outcome = system_correction(s, q, speed, s->rows, nearest, s->jump);
    for (int i = 0; i < s->n && !outcome; i++)
        x[i] += s->jump[i];
    return outcome;
}

enum outcome project_position(struct system *s, double *q)
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
    for (int pass = 0; (m->rows || active_count(s)) && pass < MAX_PASSES; pass++) {
        m->closure(s->k, q, s->rows);
        const double shut = largest(m->rows, s->rows), closed = held_gaps(s, q);
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
        const enum outcome outcome = isfinite(miss) ? correct(s, q, 0, nearest, q) : OUTCOME_NOT_FINITE;
        if (outcome)
            return outcome;
    }
    return m->rows || active_count(s) ? OUTCOME_NOT_CLOSED : OUTCOME_DONE;
}

enum outcome project_velocity(struct system *s, const double *q, double *u)
{
    const struct ccgen_model *m = s->model;
    if (!m->rows && !active_count(s))
        return OUTCOME_DONE;
    m->closure_rate(s->k, q, u, s->rows);
    s->missed_rate = largest(m->rows, s->rows);
    if (active_count(s))
        held_speeds(s, q, u);
    const enum outcome outcome = correct(s, q, 1, RANK_TOLERANCE_PROJECTED, u);
    s->moved_rate = outcome ? INFINITY : fastest(s, s->jump);
    return outcome;
}
