/* Accelerations of several states side by side; see lanes.c. */
#ifndef CCGEN_LANES_H
#define CCGEN_LANES_H

#include "model/system.h"

/* u_dot of model->lanes states side by side, value i of lane l of t, q, u and u_dot at [i * lanes + l]; lanes that
 * lose rank take the robust path one by one. The first `wanted` are states, and count as evaluations; what fills the other lanes is left
 * as it is found. Numbers that are not finite are left to the caller. `scratch` has
 * lanes_scratch(s) numbers. */
enum outcome system_acceleration_lanes(struct system *s, int wanted, const double *t, const double *q, const double *u,
                                       double *u_dot, double *scratch);
size_t lanes_scratch(const struct system *s);

/* whether the kernel over lanes has all that acts on the system; where it has not, states go one by one */
int lanes_apply(const struct system *s);

#endif
