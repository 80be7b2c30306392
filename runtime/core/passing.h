/* Steps past singular configurations; see passing.c. */
#ifndef CCGEN_PASSING_H
#define CCGEN_PASSING_H

#include "flight.h"

/* whether the step to y1 has left the closure because it passes a singular configuration */
int passes_singular(struct flight *f);

/* such a step again, guided, and perhaps shorter: f->h; what its error amounts to */
enum outcome guided_step(struct flight *f, double *error);

#endif
