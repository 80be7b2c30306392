/* States beside a singular configuration; see cut_step.c. */
#ifndef CCGEN_CUT_STEP_H
#define CCGEN_CUT_STEP_H

#include "steps/step.h"

/* Whether a step of length f->h, which the tolerance lets be as long as `allowed`, has to end so near to f->place that it is to be cut off a longer one */
int ends_beside_singularity(const struct phase *f, double allowed);

/* Such a step: cut off, with the state y1 at its end, where *ends is set. Else f->h is the length of one before it that comes as near to f->place as the
 * cut one has to begin; or as it was, where nothing is gained by that. */
enum outcome end_beside_singularity(struct phase *f, int *ends);

/* Whether the way from f->y, f->h long, passes a singular configuration before it comes to end[2n]: f->place is when. */
int passes_singularity(struct phase *f, const double *end);

/* whether velocities are not known to the tolerance at time t of it, */
int lies_beside_singularity(struct phase *f, const double *end, double t);

/* and the state y1 then, if so, */
enum outcome come_beside_singularity(struct phase *f, double t);

/* or if not, at a time from which the step does not pass f->place: stages lie on the closure. */
enum outcome come_clear_of_singularity(struct phase *f, double t);

#endif
