/* States between the rows of a run where a singular configuration lies between them. */
#ifndef CCGEN_LOOK_H
#define CCGEN_LOOK_H

#include "steps/step.h"

/* Whether the step of length f->h to end[2n] comes near a configuration where rows are dependent */
int comes_near_singularity(struct phase *f, const double *end);

/* The state at t, along the branch of the motion; NOT_CLOSED where there is none */
enum outcome look_along_branch(struct phase *f, double t);

#endif
