/* The system's accelerations; see acceleration.c. */
#ifndef CCGEN_ACCELERATION_H
#define CCGEN_ACCELERATION_H

#include "constraints/active_set.h"

/* u_dot[n], lambda[rows]; where the closure rows lose rank, by the robust path */
enum outcome system_acceleration(struct system *s, double t, const double *q, const double *u, double *u_dot,
                                 double *lambda);

/* The same with the inputs as they are; the multipliers are worked out only where lambda is not NULL. */
enum outcome accelerate(struct system *s, double t, const double *q, const double *u, double *u_dot, double *lambda);

#endif
