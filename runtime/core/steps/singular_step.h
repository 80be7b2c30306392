/* Where steps come near dependent rows of the closure; see singular_step.c. */
#ifndef CCGEN_SINGULAR_STEP_H
#define CCGEN_SINGULAR_STEP_H

#include "steps/step.h"

/* Whether the step to end[2n], which was put back to y1 with the outcome `back` and has that error, comes near dependent rows, so that it is to be taken along the branch of its
 * motion */
int comes_near_dependence(struct phase *f, enum outcome back, double error, const double *end);

/* Whether rows are so near to dependence at the end of the step, which was put back to y1, that a branch is followed there */
int ends_near_dependence(struct phase *f);

/* The part, up to `last`, of the step to end[2n] at which the cubic through its ends comes nearest to dependence; whether rows depend there */
int nearest_part(struct phase *f, const double *end, double last, double *part);

/* The length f->h of a step by collocation in place of one of length `own` by the run's own method: as long and as exact as in a run by collocation */
void take_over(struct phase *f, double own);

#endif
