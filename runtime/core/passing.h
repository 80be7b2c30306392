/* Steps past singular configurations; see passing.c. */
#ifndef CCGEN_PASSING_H
#define CCGEN_PASSING_H

#include "flight.h"

/* whether the step to end[2n] has left the closure because it passes a singular configuration; putting it back to y1 gave `back` */
int passes_singular(struct flight *f, enum outcome back, const double *end);

/* such a step again, guided, and perhaps shorter: f->h; what its error amounts to */
enum outcome guided_step(struct flight *f, double *error);

#endif
