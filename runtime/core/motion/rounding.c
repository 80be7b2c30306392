/* How exactly accelerations are known: what one refinement would change. */
#include "motion/rounding.h"

#include <math.h>

#include "constraints/refinement.h"
#include "motion/acceleration.h"

/* What refinement changes in x[n], the accelerations on the robust path; no contacts may be held */
static double change_by_refinement(struct system *s, double t, const double *q, const double *u, double *x,
                                   double *lambda, double *refined)
{
    const int refine = s->refine;
    const double inexact = s->refinement_residual;
    s->refine = 0;
    enum outcome outcome = system_acceleration(s, t, q, u, x, lambda);
    s->refine = 1;
    if (!outcome)
        outcome = system_acceleration(s, t, q, u, refined, lambda);
    s->refine = refine;
    s->refinement_residual = inexact;
    if (outcome)
        return 0.0;
    for (int i = 0; i < s->n; i++)
        refined[i] -= x[i];
    return fastest(s, refined);
}

double rounding_of_acceleration(struct system *s, double t, const double *q, const double *u, double *whole)
{
    const struct ccgen_model *m = s->model;
    const struct mark mark = s->arena->top;
    double *y = TAKE(s->arena, double, m->rows), *x = TAKE(s->arena, double, s->n), found = 0.0;
    double *lambda = TAKE(s->arena, double, m->rows);
    struct correction w;
    *whole = 0.0;
    if (!take_correction(s, &w)) {
        const struct unreduced of = {.u = u, .t = t, .y = y};
        wanted_accelerations(s, q, u, y);
        if (m->acceleration(s->k, q, u, t, s->inputs, x, lambda) || correct_by_kernel(s, q, &of, x, lambda, &w))
            found = change_by_refinement(s, t, q, u, x, lambda, w.dx);
        else
            found = fastest(s, w.dx);
        *whole = fastest(s, x);
    }
    give_back(s->arena, mark);
    return found < INFINITY && *whole < INFINITY ? found : (*whole = 0.0);
}
