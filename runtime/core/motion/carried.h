/* What small differences become along a collocated step; see carried.c. */
#ifndef CCGEN_CARRIED_H
#define CCGEN_CARRIED_H

#include "base/real.h"

enum { NODES = 8 }; /* of a step, which are taken side by side */

/* Nodes c[NODES], weights b[NODES], the matrix A[NODES][NODES] of collocation, and those of double integrals */
struct collocation {
    const double *c, *b, *twice_b, *A, *twice;
};

/* A step of length h: J[n][width][NODES], derivatives of the accelerations at the nodes by q, u and arguments, and what puts its end
 * back: `count` times, from entry first[] of the state on, pull[][n][rows[]] of what moves[][rows[]][width] make of the end. */
struct carrying {
    int n, width, count;
    double h;
    const double *J;
    int first[2], rows[2];
    const double *pull[2], *moves[2];
};

/* whole[width][columns], differences of the state and the arguments, from the start of a step to its end. Returns 0, and leaves some of
 * them, where sweeps do not contract; room[carry_room()]. */
int carry(const struct collocation *g, const struct carrying *step, int columns, double *whole, double *room);

size_t carry_room(const struct carrying *step, int columns);

#endif
