/* The path taken where closure rows lose rank; see nullspace.c. */
#ifndef CCGEN_NULLSPACE_H
#define CCGEN_NULLSPACE_H

#include "model/system.h"

/* out[n] = M x + (terms that do not depend on x): what A^T lambda must balance */
typedef void affine(const struct system *s, const double *q, const void *context, const double *x, double *out);

/* x[n] and lambda[rows + held] of least norm with A x = y (on the rows that count) and residual(x) = A^T lambda. The rows
 * of A are those of the closure, and of the first `held` rows of the held contacts below them. A row nearer to the span of
 * the others than `nearest`, relative to its joint's rows, does not count. Driven joints have the prescribed accelerations
 * at time *t, or do not move against each other where `t` is NULL. */
enum outcome solve_in_nullspace(struct system *s, const double *q, int held, const double *y, const double *t,
                                double nearest, affine *residual, const void *context, double *x, double *lambda);

/* How near the nearest row of the closure and of driven joints comes to the span of the others, of those that count;
 * 1 where rows are at right angles */
double rank_margin(struct system *s, const double *q);

/* How many of these rows count, and how near the nearest of them comes */
int row_rank(struct system *s, const double *q, double *nearest);

/* lambda[rows + drives] with lambda . A = 0 for row number 0, 1, ... of those that do not count; whether there is one */
int left_null_vector(struct system *s, const double *q, int number, double *lambda);

#endif
