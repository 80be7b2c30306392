/* The Jacobian of the accelerations by coordinates and velocities; see jacobian.c. */
#ifndef CCGEN_JACOBIAN_H
#define CCGEN_JACOBIAN_H

#include "model/system.h"

/* by_q[n][n], by_u[n][n]: how the accelerations at (t, q, u) change with each coordinate and velocity, under the contacts that are held.
 * *known is 0 where the model has no derivatives, or they are not those of the motion: both are then not to be used. */
enum outcome acceleration_jacobian(struct system *s, double t, const double *q, const double *u, double *by_q,
                                   double *by_u, int *known);

/* Numbers of scratch that it takes at most */
size_t jacobian_scratch(const struct ccgen_model *m);

#endif
