/* Orthogonal factorisation with exchange of columns (P. Businger, G. H. Golub, Numerische Mathematik 7, 1965). */
#ifndef CCGEN_ORTHOGONAL_H
#define CCGEN_ORTHOGONAL_H

#include "base/real.h"

/* Householder reflections that turn columns of g[columns][n] (stored column by column) into an upper triangle, the longest
 * remaining column first when `order` is given; returns how many columns count: one nearer to the span of the others than
 * `nearest` times the first one's length does not. Column k keeps its reflection's vector from
 * entry k on, `diagonal` the triangle's diagonal, `beta` the reflections' factors. */
int reduce_columns(int n, int columns, double *g, double nearest, double *diagonal, double *beta, int *order);

/* x <- Q x (backwards = 0) or Q^T x (backwards = 1) for the reflections of `reduce_columns` */
void reflect(int n, int rank, const double *g, const double *beta, int transposed, double *x);

/* x <- T^-T x for the upper triangle left by `reduce_columns` */
void solve_transposed_triangle(int n, int rank, const double *g, const double *diagonal, double *x);

#endif
