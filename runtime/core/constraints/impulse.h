/* Jumps of the velocities by impulses, with loops and held contacts as constraints. */
#ifndef CCGEN_IMPULSE_H
#define CCGEN_IMPULSE_H

#include "constraints/active_set.h"

/* du[n], Lambda[rows] with M du = A^T Lambda + f, A du = y, likewise; on the robust path, rows nearer to the others than
 * `nearest` do not count */
enum outcome system_impulse(struct system *s, const double *q, const double *f, const double *y, double nearest,
                            double *du, double *Lambda);

/* du[n] without other impulses than those of the closure and of the held contacts, which bring the rates of the first and
 * the rates of the gaps of the second, with `speed` also the sliding of those that stick, to rows[rows + held]; `nearest`
 * as above */
enum outcome system_correction(struct system *s, const double *q, int speed, double *rows, double nearest, double *du);

#endif
