/* Rows of constraints in units of the coordinates; see rows.c. */
#ifndef CCGEN_ROWS_H
#define CCGEN_ROWS_H

#include "model/system.h"

/* The rows of the closure as columns of g[rows][n], in units of the coordinates, and lengths[rows] that make them comparable, by which they are divided */
void scaled_closure_rows(const struct system *s, const double *q, double *g, double *length);

/* Move the rows of the closure that are on to the front of g[rows][n]. */
void keep_rows_on(const struct system *s, double *g);

/* lambda[rows] of the closure from those of its rows that are on; the others' are 0 */
void spread_multipliers(const struct system *s, const double *of_rows_on, double *lambda);

/* The same of driven joints, then of the first `held` rows of held contacts. right[drives + held]: prescribed accelerations at the time *t, or zeros where
 * that is NULL, then y[held]. push[contacts] are zeros. */
void scaled_other_rows(struct system *s, const double *q, int held, const double *y, const double *t, double *push,
                       double *g, double *length, double *right);

/* Where driven joint d is or, of velocities x[n], how fast it moves */
double driven_by(const struct ccgen_model *m, int d, const double *x);

#endif
