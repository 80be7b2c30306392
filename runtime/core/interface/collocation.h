/* The motion along a step of a run, by collocation; see collocation.c. */
#ifndef CCGEN_COLLOCATION_H
#define CCGEN_COLLOCATION_H

#include "interface/forces.h"

/* Nodes c[stages], the matrix A[stages][stages] of integrals over them, and its square. */
struct tableau {
    int stages;
    const double *c, *A, *twice;
};

/* When sweeps end: after so `many`; where what is left of changes, at the rate at which they fall, is the part `small` of accelerations;
 * where these change by less than `stays`, and no less from one to the next. */
struct sweeping {
    int many;
    double small, stays;
};

/* A step from (t, q[n], u[n]) over h, whose end is near to q1[n], u1[n], with the accelerations[n] at both. */
struct stride {
    double t, h;
    const double *q, *u, *q1, *u1, *at_start, *at_end;
};

/* Accelerations W[stages][n] at the nodes of the motion through the start of a step, with contacts held; *met is 0 where sweeps do
 * not contract. Where a state has no accelerations, *when is its time. */
enum outcome collocate_motion(struct system *s, struct held held, const struct tableau *g, struct sweeping end,
                              const struct stride *step, double *W, int *met, double *when);

#endif
