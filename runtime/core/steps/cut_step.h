/* States beside a singular configuration; see cut_step.c. */
#ifndef CCGEN_CUT_STEP_H
#define CCGEN_CUT_STEP_H

#include "steps/step.h"

/* how long a step past a singular configuration is that is cut, in lengths that the tolerance allows one */
extern const double CUT_LENGTH;

/* the part of it, or less, by which its cut may lie beside the configuration in its middle */
extern const double CUT_REACH;

/* The state y1 at the time `until` beside f->place, of a step by collocation that goes on past both, f->h being what is left of it; in *error what that step
 * misses, accepted up to 1. It is about `length` long. */
enum outcome cut_step(struct phase *f, double until, double length, double *error);

/* Whether velocities are not known to the tolerance at t where the way from f->y, f->h long, leads to end[2n], and the singular configuration that
 * this comes from: f->place is when. */
int lies_beside_singularity(struct phase *f, const double *end, double t);

/* The state y1 at that t */
enum outcome come_beside_singularity(struct phase *f, const double *end, double t);

#endif
