/* Derivatives of accelerations along directions; see tangent.c. */
#ifndef CCGEN_TANGENT_H
#define CCGEN_TANGENT_H

#include "model/system.h"

/* The derivative of that name; NULL where the model has none of it, or it vanishes */
const struct ccgen_named_tangent *find_tangent(const struct ccgen_model *m, const char *name);

/* Directions in the arguments of accelerations: blocks in q, in u, in k, and in t and inputs, of `blocks` in all. Those in an
 * argument begin with block first[], and there are count[] of them; the others do not move it. */
enum { MOVES_Q, MOVES_U, MOVES_K, MOVES_T, MOVES }; /* four */
struct directions {
    struct ccgen_arguments by;
    int blocks, first[4], count[4];
};

/* tangents[blocks][n + rows][lanes] of accelerations and multipliers in flight, at a state with u_dot[n] and lambda[rows]. *miss
 * is negative where the generated functions have solved; else by how much, at most and relatively, rows that depend on others
 * keep the directions from being those of a motion. */
enum outcome acceleration_tangents(struct system *s, double t, const double *q, const double *u, const double *u_dot,
                                   const double *lambda, const struct directions *along, double *tangents,
                                   double *miss);

/* tangents[blocks][n + rows][lanes]: jumps and impulses of `system_impulse` along right[blocks][n + rows][lanes], generalized
 * impulses and behind them closure rates */
enum outcome impulse_tangents(struct system *s, const double *q, int blocks, const double *right, double *tangents);

/* The transposed matrix K[stages n][stages n] of the equations that the tangents w of the accelerations at the nodes of a step
 * fulfil, w_i = J_q,i (.. + h^2 twice_ij w_j) + J_u,i (.. + h A_ij w_j) (docs/theory, eq. 11.7), from J[stages][n][width], whose
 * first n columns are by q and the next n by u */
void collocate_tangents(int n, int stages, int width, double h, const double *A, const double *twice, const double *J,
                        double *K);

/* J, as above, from derivatives by q and u at the nodes to those by q and u at the start of the step, accelerations held */
void tangents_at_start(int n, int stages, int width, double h, const double *c, double *J);

#endif
