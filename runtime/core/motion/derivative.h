/* The right-hand side that methods integrate. */
#ifndef CCGEN_DERIVATIVE_H
#define CCGEN_DERIVATIVE_H

#include "model/system.h"

/* dy/dt = [u; u_dot]; of a system that follows a branch, of the state on it */
enum outcome system_derivative(struct system *s, double t, const double *y, double *dy);

#endif
