/* Digits that the elimination loses where masses differ by many orders, and their recovery; see refine.c. */
#ifndef CCGEN_REFINE_H
#define CCGEN_REFINE_H

#include "core.h"

/* The accelerations u_dot[n] and multipliers lambda[rows] of the kernel, refined in place. s->inexact becomes at least the
 * relative size of the last correction where that does not become small; OUTCOME_INEXACT where no digits are right. */
enum outcome refine_acceleration(struct system *s, double t, const double *q, const double *u, double *u_dot,
                                 double *lambda);

/* The same for du[n] and Lambda[rows] of the impulsive kernel, from f[n] and y[rows] */
enum outcome refine_impulse(struct system *s, const double *q, const double *f, const double *y, double *du,
                            double *Lambda);

/* How far the kernel's accelerations are from right at a state: the size of their first correction, which is not made, and
 * in *whole their own size. On the robust path, what refinement changes. Both 0 for a state without accelerations. */
double rounding_of_acceleration(struct system *s, double t, const double *q, const double *u, double *whole);

#endif
