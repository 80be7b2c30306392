/* Steps that end where they are asked to; see step_end.c. */
#ifndef CCGEN_STEP_END_H
#define CCGEN_STEP_END_H

#include "steps/step.h"

/* step of length h from (t, y) to y1, put back onto the closure whatever its error */
enum outcome projected_step(struct phase *f, double h);

#endif
