/* Where masses differ by many orders, eliminating one acceleration after another loses digits (docs/theory, section 4.11).
 * The unreduced equations do not: what they miss by,
 *
 *     Z1 = M x + h - A^T lambda,   Z2 = A x - y,
 *
 * costs one sweep outwards and one inwards, and is known to its own rounding. The kernel `impulse` answers it with a
 * correction, M dx - A^T dlambda = -Z1, A dx = -Z2, whose error relative to the correction is that of the kernel. So the size
 * of the correction tells how many digits were lost, and adding it brings them back (iterative refinement with residuals in
 * working precision: R. D. Skeel, Mathematics of Computation 35, 1980).
 */
#include "constraints/refinement.h"

#include <float.h>
#include <math.h>

#include "base/tolerances.h"

enum { PASSES = 4 };

int take_correction(const struct system *s, struct correction *w)
{
    const size_t n = s->n, rows = s->model->rows;
    w->rows = TAKE(s->arena, double, (rows * n));
    w->f = TAKE(s->arena, double, n);
    w->dx = TAKE(s->arena, double, n);
    w->miss = TAKE(s->arena, double, rows);
    w->dlambda = TAKE(s->arena, double, rows);
    return s->arena->ran_out;
}

int correct_by_kernel(struct system *s, const double *q, const struct unreduced *of, const double *x,
                      const double *lambda, struct correction *w)
{
    const struct ccgen_model *m = s->model;
    const size_t n = s->n;
    if (of->u)
        m->inverse_dynamics(s->k, q, of->u, of->t, s->inputs, x, w->f);
    else
        m->momentum(s->k, q, x, w->f);
    for (size_t i = 0; i < n; i++)
        w->f[i] = of->u ? -w->f[i] : of->f[i] - w->f[i];
    if (m->rows)
        m->closure_jacobian(s->k, q, w->rows);
    for (int j = 0; j < m->rows; j++) {
        w->miss[j] = of->y[j];
        for (size_t i = 0; i < n; i++) {
            w->miss[j] -= w->rows[j * n + i] * x[i];
            w->f[i] += w->rows[j * n + i] * lambda[j];
        }
    }
    return m->impulse(s->k, q, w->f, w->miss, w->dx, w->dlambda);
}

/* Whether nothing moves whatever impulses act: rows and drives leave no motion, and what they want is none. The jump is zero then, of which
 * no digit is to be known, as the rounding that is found in its place has none. */
static int stands_still(const struct system *s, const struct unreduced *of)
{
    if (of->u || s->n > s->rows_on + s->model->drives)
        return 0;
    for (int k = 0; k < s->rows_on; k++)
        if (of->y[s->on[k]] != 0.0)
            return 0;
    return 1;
}

static enum outcome refine(struct system *s, const double *q, const struct unreduced *of, double *x, double *lambda)
{
    struct correction w;
    double left = INFINITY;
    if (!(fastest(s, x) < INFINITY)) /* no number at all: nothing to refine */
        return OUTCOME_DONE;
    const struct mark mark = s->arena->top;
    if (take_correction(s, &w)) {
        give_back(s->arena, mark);
        return OUTCOME_NO_MEMORY;
    }
    for (int pass = 0; pass < PASSES && left > REFINED_BY_KERNEL; pass++) {
        if (correct_by_kernel(s, q, of, x, lambda, &w))
            break;
        const double whole = of->u ? fmax(fastest(s, x), s->acceleration_scale) : fastest(s, x);
        left = fastest(s, w.dx) / (whole > 0.0 ? whole : 1.0);
        for (int i = 0; i < s->n; i++)
            x[i] += w.dx[i];
        for (int j = 0; j < s->model->rows; j++)
            lambda[j] += w.dlambda[j];
    }
    give_back(s->arena, mark);
    if (stands_still(s, of))
        return OUTCOME_DONE;
    if (left > REFINED_BY_KERNEL)
        s->refinement_residual = fmax(s->refinement_residual, left);
    return left <= HOPELESS ? OUTCOME_DONE : OUTCOME_INEXACT;
}

void wanted_accelerations(const struct system *s, const double *q, const double *u, double *y)
{
    if (s->model->rows)
        s->model->closure_bias(s->k, q, u, y);
    for (int j = 0; j < s->model->rows; j++)
        y[j] = -y[j];
}

enum outcome refine_acceleration(struct system *s, double t, const double *q, const double *u, double *u_dot,
                                 double *lambda)
{
    const struct mark mark = s->arena->top;
    double *y = TAKE(s->arena, double, s->model->rows);
    const struct unreduced of = {.u = u, .t = t, .y = y};
    enum outcome outcome = OUTCOME_NO_MEMORY;
    if (!s->arena->ran_out) {
        wanted_accelerations(s, q, u, y);
        outcome = refine(s, q, &of, u_dot, lambda);
    }
    give_back(s->arena, mark);
    return outcome;
}

enum outcome refine_impulse(struct system *s, const double *q, const double *f, const double *y, double *du,
                            double *Lambda)
{
    const struct unreduced of = {.f = f, .y = y};
    return refine(s, q, &of, du, Lambda);
}
