/* Digits that the elimination loses where masses differ by many orders, and their recovery; see refinement.c. */
#ifndef CCGEN_REFINEMENT_H
#define CCGEN_REFINEMENT_H

#include "model/system.h"

/* The accelerations u_dot[n] and multipliers lambda[rows] of the kernel, refined in place. s->inexact becomes at least the
 * relative size of the last correction where that does not become small; OUTCOME_INEXACT where no digits are right. */
enum outcome refine_acceleration(struct system *s, double t, const double *q, const double *u, double *u_dot,
                                 double *lambda);

/* The same for du[n] and Lambda[rows] of the impulsive kernel, from f[n] and y[rows] */
enum outcome refine_impulse(struct system *s, const double *q, const double *f, const double *y, double *du,
                            double *Lambda);

/* What the unreduced equations are solved for: motion with velocities u, or where u is NULL a jump by the generalized impulses f. */
struct unreduced {
    const double *u, *f;
    double t;
    const double *y; /* [rows] of A x */
};

/* A correction dx, dlambda to x, lambda, and what it is worked out from. */
struct correction {
    double *rows, *f, *miss, *dx, *dlambda; /* [rows][n], [n], [rows], [n], [rows] */
};

/* Its arrays from the arena of the system: 0, or 1 when memory runs out */
int take_correction(const struct system *s, struct correction *w);

/* The correction w->dx, w->dlambda from what x, lambda miss (eq. 4.14); nonzero where the kernel has none. */
int correct_by_kernel(struct system *s, const double *q, const struct unreduced *of, const double *x,
                      const double *lambda, struct correction *w);

/* y[rows] of the accelerations: A x = -dA/dt u */
void wanted_accelerations(const struct system *s, const double *q, const double *u, double *y);

#endif
