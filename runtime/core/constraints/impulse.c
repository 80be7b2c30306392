/* Jumps of the velocities: the generated kernels, or the null-space path where they lose rank, and along a branch. */
#include "constraints/impulse.h"

#include "constraints/branch.h"
#include "constraints/contact_forces.h"
#include "constraints/nullspace.h"
#include "constraints/refinement.h"

enum outcome system_impulse(struct system *s, const double *q, const double *f, const double *y, double nearest,
                            double *du, double *Lambda)
{
    if (!is_place_on_branch(s, q) && !s->model->impulse(s->k, q, f, y, du, Lambda))
        return s->refine ? refine_impulse(s, q, f, y, du, Lambda) : OUTCOME_DONE;
    return solve_in_nullspace(s, q, 0, y, NULL, nearest, momentum_residual, f, du, Lambda);
}

enum outcome system_correction(struct system *s, const double *q, int speed, double *rows, double nearest, double *du)
{
    const struct ccgen_model *m = s->model;
    const int held = active_rows(s, speed);
    const struct mark mark = s->arena->top;
    double *none = TAKE_ZEROS(s->arena, double, s->n), *multipliers = TAKE(s->arena, double, m->rows + held);
    enum outcome outcome = OUTCOME_NO_MEMORY;
    if (s->arena->ran_out)
        goto end;
    outcome = OUTCOME_DONE;
    int dependent = m->impulse(s->k, q, none, rows, du, NULL);
    if (!dependent && active_count(s))
        dependent = s->refine || add_contact_jump(s, q, speed, rows + m->rows, du);
    if (dependent)
        outcome = solve_in_nullspace(s, q, held, rows, NULL, nearest, momentum_residual, none, du, multipliers);
end:
    give_back(s->arena, mark);
    return outcome;
}
