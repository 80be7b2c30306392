/* Steps whose ends are put back onto the closure whatever their error. */
#include "steps/step_end.h"

#include <math.h>

#include "base/tolerances.h"
#include "steps/singular_step.h"

/* Step of length h, put back onto the closure whatever its error. What a method iterates goes to rounding, so that y1 is a smooth
 * function of h: landing on an event needs that. */
static enum outcome step_put_back(struct phase *f, double h)
{
    const struct tolerance tolerance = f->run->tolerance, little = {.rtol = ITERATED * tolerance.rtol,
                                                                    .atol = ITERATED * tolerance.atol,
                                                                    .unit = tolerance.unit};
    enum outcome outcome = unprojected_step(f, h, to_rounding(f->s));
    if (outcome == OUTCOME_NO_CONVERGENCE && little.rtol > 0.0 &&
        estimates_errors(f->by)) { /* loads that all but cancel have a rounding of their own */
        double error = INFINITY;
        outcome = unprojected_step(f, h, little);
        outcome = outcome ? outcome : step_error(f, &error);
        outcome = outcome || error <= 1.0 ? outcome : OUTCOME_NO_CONVERGENCE;
    }
    return outcome ? outcome : project_step_end(f);
}

enum outcome projected_step(struct phase *f, double h)
{
    enum outcome outcome = step_put_back(f, h);
    if (!outcome && f->run->fixed_step == 0.0 && !f->s->branch && ends_near_dependence(f)) {
        outcome = follow_branch(f); /* it was to end elsewhere, where nothing told of the place */
        if (f->s->branch && !outcome)
            outcome = step_put_back(f, h);
        if (none_told(outcome)) {
            outcome = take_closure(f);
            outcome = outcome ? outcome : step_put_back(f, h);
        }
    }
    return outcome;
}
