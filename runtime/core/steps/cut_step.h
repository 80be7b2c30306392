/* States beside a singular configuration; see cut_step.c. */
#ifndef CCGEN_CUT_STEP_H
#define CCGEN_CUT_STEP_H

#include "steps/step.h"

/* Whether a step of length f->h, which the tolerance lets be as long as `allowed`, has to end so near to f->place that it is to be cut off a longer one */
int ends_beside_singularity(const struct phase *f, double allowed);

/* Such a step: cut off, with the state y1 at its end, where *ends is set. Else f->h is the length of one before it that comes as near to f->place as the
 * cut one has to begin; or as it was, where nothing is gained by that. */
enum outcome end_beside_singularity(struct phase *f, int *ends);

/* The same of a look, where `tries` before have missed too much and no step may go on past the time `limit` */
enum outcome cut_or_shorten(struct phase *f, int tries, double limit, int *ends);

/* Whether a step with f->place in its middle can be cut after `way` */
int can_be_cut(const struct phase *f, double way);

/* How near to dependence rows are where velocities are just known to the tolerance, or if that is finer to the default one */
double near_dependence(const struct phase *f);

#endif
