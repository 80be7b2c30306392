/* Steps past singular configurations; see singular_step.c. */
#ifndef CCGEN_SINGULAR_STEP_H
#define CCGEN_SINGULAR_STEP_H

#include "steps/step.h"

/* whether the step to end[2n], which was put back to y1 with the outcome `back`, passes a singular configuration, or ends
 * beside one, so that it is to be taken again: f->place is when */
int crosses_singularity(struct phase *f, enum outcome back, double error, const double *end);

/* the length of a step that may be as long as f->h, and how it is taken, from f->place */
void place_about_singularity(struct phase *f);

/* whether the singular configuration is passed elsewhere in the step to end[2n] than f->place says, which then says it better */
int misplaced(struct phase *f, const double *end);

#endif
