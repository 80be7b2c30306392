/* The path taken where closure rows lose rank; see nullspace.c. */
#ifndef CCGEN_NULLSPACE_H
#define CCGEN_NULLSPACE_H

#include "algebra/orthogonal.h"
#include "model/system.h"

/* out[n] = M x + (terms that do not depend on x): what A^T lambda must balance */
typedef void affine(const struct system *s, const double *q, const void *context, const double *x, double *out);

/* The rows of the closure that are on, of driven joints and of held contacts as columns of g, factorised */
struct factors {
    double *g, *length, *diagonal, *beta; /* [rows][n], [rows] */
    double *right;                        /* [rows] right-hand sides */
    int *order;                           /* [rows] */
};

/* out[n] = M x - f for generalized impulses f[n]: what impulses of the constraints must balance, an `affine` */
void momentum_residual(const struct system *s, const double *q, const void *f, const double *x, double *out);

/* A place, its rows factorised, and all motions that these leave: one of them, and those that none of the rows sees */
struct nullspace {
    const double *q;       /* [n] */
    int rows, fixed, rank; /* all rows that are on, those of the closure and of driven joints, those that count */
    int along; /* of these the rows that the branch of the system keeps by itself, or 0: the factors are then of the others along it */
    int accelerates; /* motions are accelerations, not jumps */
    struct factors factors;
    double *particular;  /* [n] */
    double *null, *mass; /* [n - rank][n] and the factor of their masses */
    struct least_norm least_norm;
    double *b, *more, *every; /* scratch: [n], [n], [rows] */
};

/* All motions x[n] with A x = y[all rows + held] on the rows that count, from the arena; at a state of the system's branch those along it, and multipliers of the closure
 * are then NaN: they may have no bound. The rows
 * of A are those of the closure, and of the first `held` rows of the held contacts below them. A row nearer to the span of
 * the others than `nearest`, relative to its joint's rows, does not count. Driven joints have the prescribed accelerations
 * at time *t, or do not move against each other where `t` is NULL. */
enum outcome factorise_motions(struct system *s, const double *q, int held, const double *y, const double *t,
                               double nearest, struct nullspace *z);

/* That of these motions, and lambda[all rows + held] of least norm, 0 of those that are off, with residual(x) = A^T lambda */
void choose_motion(struct system *s, const struct nullspace *z, affine *residual, const void *context, double *x,
                   double *lambda);

/* The same of those that no row sees, by generalized impulses f[n]: a jump that leaves all rows as they are */
void choose_jump(struct system *s, struct nullspace *z, const double *f, double *du, double *Lambda);

/* The velocities along the system's branch nearest to u[n] in the metric of the masses, at its last place: driven joints move as fast, and closed gaps and what
 * sticks stays */
enum outcome keep_velocities_along_branch(struct system *s, const double *q, double *u);

/* Both at once */
enum outcome solve_in_nullspace(struct system *s, const double *q, int held, const double *y, const double *t,
                                double nearest, affine *residual, const void *context, double *x, double *lambda);

/* How near the nearest row of the closure and of driven joints comes to the span of the others, of those that count;
 * 1 where rows are at right angles */
double rank_margin(struct system *s, const double *q);

/* How many of these rows count, of which those that are off are none, and how near the nearest of them comes */
int row_rank(struct system *s, const double *q, double *nearest);

/* motions[n - rank][n]: a basis of the motions that none of these rows that count sees, orthonormal in units; the rank, or -1 when
 * memory runs out */
int free_motions(struct system *s, const double *q, double *motions);

/* lambda[rows + drives] with lambda . A = 0 for row number 0, 1, ... of those that do not count; whether there is one */
int left_null_vector(struct system *s, const double *q, int number, double *lambda);

#endif
