/* The right-hand side that methods integrate. */
#ifndef CCGEN_DERIVATIVE_H
#define CCGEN_DERIVATIVE_H

#include "model/system.h"

/* dy/dt = [u; u_dot]; of a guided system, of the nearest state on the closure */
enum outcome system_derivative(struct system *s, double t, const double *y, double *dy);

#endif
