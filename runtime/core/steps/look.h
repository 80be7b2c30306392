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

#endif
