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
#include "refine.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

enum { PASSES = 4 };
static const double ENOUGH = 4096.0 * DBL_EPSILON; /* a correction smaller than this leaves an error smaller than rounding */
static const double HOPELESS = 1e-3;  /* a last correction larger than this, and nothing is known */

/* What is solved: motion with velocities u, or where u is NULL a jump by the generalized impulses f */
struct equations {
    const double *u, *f;
    double t;
    const double *y; /* [rows] of A x */
};

struct scratch {
    double *rows, *f, *miss, *dx, *dlambda; /* [rows][n], [n], [rows], [n], [rows] */
};

static int make_scratch(const struct system *s, struct scratch *w)
{
    const size_t n = s->n, rows = s->model->rows;
    w->rows = malloc((rows * n + 2 * n + 3 * rows + 1) * sizeof *w->rows);
    if (!w->rows)
        return 1;
    w->f = w->rows + rows * n;
    w->dx = w->f + n;
    w->miss = w->dx + n;
    w->dlambda = w->miss + rows;
    return 0;
}

/* The largest entry; those of a floating root's place count by the mechanism's length. */
static double size(const struct system *s, const double *x)
{
    double found = 0.0;
    for (int i = 0; i < s->n; i++) {
        const double entry = fabs(x[i]) / (i < s->model->base ? s->length : 1.0);
        found = fmax(found, isnan(entry) ? INFINITY : entry);
    }
    return found;
}

/* The correction dx, dlambda to x, lambda, from what these miss (eq. 4.14); nonzero where the kernel has none. */
static int correction(struct system *s, const double *q, const struct equations *of, const double *x, const double *lambda,
                      struct scratch *w)
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

static enum outcome refine(struct system *s, const double *q, const struct equations *of, double *x, double *lambda)
{
    struct scratch w;
    double left = INFINITY;
    if (!(size(s, x) < INFINITY)) /* no number at all: nothing to refine */
        return OUTCOME_DONE;
    if (make_scratch(s, &w))
        return OUTCOME_NO_MEMORY;
    for (int pass = 0; pass < PASSES && left > ENOUGH; pass++) {
        if (correction(s, q, of, x, lambda, &w))
            break;
        const double whole = of->u ? fmax(size(s, x), s->usual) : size(s, x);
        left = size(s, w.dx) / (whole > 0.0 ? whole : 1.0);
        for (int i = 0; i < s->n; i++)
            x[i] += w.dx[i];
        for (int j = 0; j < s->model->rows; j++)
            lambda[j] += w.dlambda[j];
    }
    free(w.rows);
    if (left > ENOUGH)
        s->inexact = fmax(s->inexact, left);
    return left <= HOPELESS ? OUTCOME_DONE : OUTCOME_INEXACT;
}

/* y[rows] of the accelerations: A x = -dA/dt u */
static double *wanted_accelerations(const struct system *s, const double *q, const double *u)
{
    double *y = malloc((s->model->rows + 1) * sizeof *y);
    if (y && s->model->rows)
        s->model->closure_bias(s->k, q, u, y);
    for (int j = 0; y && j < s->model->rows; j++)
        y[j] = -y[j];
    return y;
}

enum outcome refine_acceleration(struct system *s, double t, const double *q, const double *u, double *u_dot,
                                 double *lambda)
{
    double *y = wanted_accelerations(s, q, u);
    const struct equations of = {.u = u, .t = t, .y = y};
    const enum outcome outcome = y ? refine(s, q, &of, u_dot, lambda) : OUTCOME_NO_MEMORY;
    free(y);
    return outcome;
}

enum outcome refine_impulse(struct system *s, const double *q, const double *f, const double *y, double *du,
                            double *Lambda)
{
    const struct equations of = {.f = f, .y = y};
    return refine(s, q, &of, du, Lambda);
}

/* What refinement changes in x[n], the accelerations on the robust path; no contacts may be held */
static double change_by_refinement(struct system *s, double t, const double *q, const double *u, double *x, double *lambda,
                                   double *refined)
{
    const int refine = s->refine;
    const double inexact = s->inexact;
    s->refine = 0;
    enum outcome outcome = system_acceleration(s, t, q, u, x, lambda);
    s->refine = 1;
    if (!outcome)
        outcome = system_acceleration(s, t, q, u, refined, lambda);
    s->refine = refine;
    s->inexact = inexact;
    if (outcome)
        return 0.0;
    for (int i = 0; i < s->n; i++)
        refined[i] -= x[i];
    return size(s, refined);
}

double rounding_of_acceleration(struct system *s, double t, const double *q, const double *u, double *whole)
{
    const struct ccgen_model *m = s->model;
    double *y = wanted_accelerations(s, q, u), *x = malloc((s->n + m->rows + 1) * sizeof *x), found = 0.0;
    struct scratch w = {0};
    *whole = 0.0;
    if (y && x && !make_scratch(s, &w)) {
        const struct equations of = {.u = u, .t = t, .y = y};
        if (m->acceleration(s->k, q, u, t, s->inputs, x, x + s->n) || correction(s, q, &of, x, x + s->n, &w))
            found = change_by_refinement(s, t, q, u, x, x + s->n, w.dx);
        else
            found = size(s, w.dx);
        *whole = size(s, x);
    }
    free(w.rows);
    free(x);
    free(y);
    return found < INFINITY && *whole < INFINITY ? found : (*whole = 0.0);
}
