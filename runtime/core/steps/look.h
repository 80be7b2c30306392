/* States between the rows of a run where a singular configuration lies between them. */
#ifndef CCGEN_LOOK_H
#define CCGEN_LOOK_H

#include "steps/step.h"

/* Whether the way from f->y, f->h long, passes a singular configuration before it comes to end[2n]: f->place is when. */
int passes_singularity(struct phase *f, const double *end);

/* whether velocities are not known to the tolerance at time t of it, */
int lies_beside_singularity(struct phase *f, const double *end, double t);

/* and the state y1 then, if so, */
enum outcome come_beside_singularity(struct phase *f, double t);

/* or if not, at a time from which the step does not pass f->place: stages lie on the closure. */
enum outcome come_clear_of_singularity(struct phase *f, double t);

/* Whether the step of length f->h to end[2n] comes near a configuration where rows are dependent */
int comes_near_singularity(struct phase *f, const double *end);

/* The state at t, along the branch of the motion; NOT_CLOSED where there is none */
enum outcome look_along_branch(struct phase *f, double t);

#endif
