/* Orthogonal factorisation with exchange of columns (P. Businger, G. H. Golub, Numerische Mathematik 7, 1965). */
#ifndef CCGEN_ORTHOGONAL_H
#define CCGEN_ORTHOGONAL_H

#include "base/arena.h"

/* Householder reflections that turn columns of g[columns][n] (stored column by column) into an upper triangle, the longest
 * remaining column first when `order` is given; returns how many columns count: one nearer to the span of the others than
 * `nearest` times the first one's length does not. Column k keeps its reflection's vector from
 * entry k on, `diagonal` the triangle's diagonal, `beta` the reflections' factors. */
int reduce_columns(int n, int columns, double *g, double nearest, double *diagonal, double *beta, int *order);

/* x <- Q x (backwards = 0) or Q^T x (backwards = 1) for the reflections of `reduce_columns` */
void reflect(int n, int rank, const double *g, const double *beta, int transposed, double *x);

/* x <- T^-T x for the upper triangle left by `reduce_columns` */
void solve_transposed_triangle(int n, int rank, const double *g, const double *diagonal, double *x);

/* A second factorisation, of the rows of a triangle */
struct least_norm {
    double *rows, *diagonal, *beta; /* [columns][columns], [columns] */
    int kept;
};

void take_least_norm(struct arena *arena, struct least_norm *room, size_t columns);

/* Factorise the rows of the triangle of which `reduce_columns` has kept `rank` columns in g, each column times its length and its weight
 * (each 1 where that is NULL). */
void prepare_least_norm(int n, int columns, int rank, const double *g, const double *diagonal, const int *order,
                        const double *length, const double *weight, struct least_norm *room);

/* x[columns] of least norm with b = sum of x[j] times column j times its length times its weight. What of b[n] they do not reach is left
 * out; b is destroyed. */
void find_least_norm(int n, int columns, int rank, const double *g, const double *beta, double *b,
                     const struct least_norm *room, double *x);

#endif
