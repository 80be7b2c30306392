/* Projection onto the closure: Gauss-Newton in the metric of the mass matrix (docs/theory, section 6).
 *
 * The correction M^-1 A^T (A M^-1 A^T)^-1 c is what the impulsive equations give for closure rates -c, so internal
 * impulses do it: linear and angular momentum stay as they are.
 */
#include "core.h"

#include <float.h>
#include <math.h>

enum { MAX_PASSES = 20 };

static double largest(int n, const double *x)
{
    double found = 0.0;
    for (int i = 0; i < n; i++)
        found = fmax(found, isnan(x[i]) ? INFINITY : fabs(x[i]));
    return found;
}

enum outcome project_position(struct system *s, double *q)
{
    const struct ccgen_model *m = s->model;
    const double unit = 2.0 * DBL_EPSILON * s->length; /* the last digit of an angle moves a link's end by that much */
    double angles = m->links;
    for (int i = m->base; i < s->n; i++)
        angles += fabs(q[i]);
    double before = INFINITY;
    for (int pass = 0; m->rows && pass < MAX_PASSES; pass++) {
        m->closure(s->k, q, s->rows);
        const double miss = largest(m->rows, s->rows);
        const int stagnant = miss <= 16.0 * unit * angles && miss > 0.5 * before;
        if (miss <= unit * m->links || stagnant)
            return OUTCOME_DONE;
        before = miss;
        for (int i = 0; i < m->rows; i++)
            s->rows[i] = -s->rows[i];
        if (!isfinite(miss))
            return OUTCOME_NOT_FINITE;
        const enum outcome outcome = system_impulse(s, q, s->zero, s->rows, NEAREST_PROJECTED, s->jump, s->multipliers);
        if (outcome)
            return outcome;
        for (int i = 0; i < s->n; i++)
            q[i] += s->jump[i];
    }
    return m->rows ? OUTCOME_NOT_CLOSED : OUTCOME_DONE;
}

enum outcome project_velocity(struct system *s, const double *q, double *u)
{
    const struct ccgen_model *m = s->model;
    if (!m->rows)
        return OUTCOME_DONE;
    m->closure_rate(s->k, q, u, s->rows);
    for (int i = 0; i < m->rows; i++)
        s->rows[i] = -s->rows[i];
    const enum outcome outcome = system_impulse(s, q, s->zero, s->rows, NEAREST_PROJECTED, s->jump, s->multipliers);
    if (outcome)
        return outcome;
    for (int i = 0; i < s->n; i++)
        u[i] += s->jump[i];
    return OUTCOME_DONE;
}
