/* Projection onto the closure and the held contacts; see projection.c. */
#ifndef CCGEN_PROJECTION_H
#define CCGEN_PROJECTION_H

#include "constraints/active_set.h"

/* The nearest state on the closure, held contacts closed, in the metric of the mass matrix, position then
 * velocity, in place */
enum outcome project_position(struct system *s, double *q);
enum outcome project_velocity(struct system *s, const double *q, double *u);

/* Both; along the system's branch where it follows one */
enum outcome project_state(struct system *s, double *q, double *u);

#endif
