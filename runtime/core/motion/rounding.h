/* How exactly accelerations are known; see rounding.c. */
#ifndef CCGEN_ROUNDING_H
#define CCGEN_ROUNDING_H

#include "model/system.h"

/* How far the kernel's accelerations are from right at a state: the size of their first correction, which is not made, and
 * in *whole their own size. On the robust path, what refinement changes. Both 0 for a state without accelerations. */
double rounding_of_acceleration(struct system *s, double t, const double *q, const double *u, double *whole);

#endif
