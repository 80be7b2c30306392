/* What small differences become along a collocated step; see carried.c. */
#ifndef CCGEN_CARRIED_H
#define CCGEN_CARRIED_H

#include "base/real.h"

/* Nodes c[stages], weights b[stages], the matrix A[stages][stages] of collocation, and those of double integrals */
struct collocation {
    int stages;
    const double *c, *b, *twice_b, *A, *twice;
};

/* A step of length h: J[stages][n][width], derivatives of the accelerations at the nodes by q, u and arguments, and what puts its end
 * back: `count` times, from entry first[] of the state on, pull[][n][rows[]] of what moves[][rows[]][width] make of the end. */
struct carrying {
    int n, width, count;
    double h;
    const double *J;
    int first[2], rows[2];
    const double *pull[2], *moves[2];
};

enum { COLUMNS = 4 }; /* differences that are taken side by side */

/* whole[width][side], differences of the state and the arguments, one or COLUMNS of them, from the start of a step to its end. Returns
 * 0, and leaves them, where sweeps do not contract; room[(5 stages n + width) side]. */
int carry(const struct collocation *g, const struct carrying *step, int side, double *whole, double *room);

#endif
