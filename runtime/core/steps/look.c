/* States between the rows of a run where a singular configuration lies between them; see look.h. */
#include "steps/look.h"

#include <math.h>

#include "base/tolerances.h"
#include "steps/singular_step.h"
#include "steps/step_control.h"

int comes_near_singularity(struct phase *f, const double *end)
{
    double part;
    const int rank = f->s->rows_on;
    if (!f->branch.chart || !projects(f))
        return 0;
    if (nearest_part(f, end, 1.0, &part))
        return 1;
    f->at.widest = fmax(closure_margin(f->s, f->y, rank), closure_margin(f->s, end, rank));
    return is_beside_place(f, f->y) || is_beside_place(f, end);
}

enum outcome look_along_branch(struct phase *f, double t)
{
    const enum outcome outcome = follow_branch(f);
    if (outcome)
        return outcome;
    return f->s->branch ? advance_to(f, t) : OUTCOME_NOT_CLOSED;
}
