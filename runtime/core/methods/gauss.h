/* Gauss-Legendre collocation: gauss_sweeps.c finds the accelerations of the stages, gauss_ends.c compares those at the ends of a step with them,
 * gauss.c makes steps of them. */
#ifndef CCGEN_GAUSS_H
#define CCGEN_GAUSS_H

#include "methods/method.h"

#include "methods/gauss_tableau.h"

enum { ORDER = 16 };

/* What the scratch holds. Stages lie side by side, x[i][STAGES], or in blocks of as many as there are lanes. A row stands for
 * each acceleration, and one more for the power if the system has it. */
struct gauss {
    double t, h;        /* where the last step began, and its length */
    int tried;          /* whether there was one since the last restart */
    int known;          /* whether `legendre` holds its stage polynomial */
    int replaced;       /* whether DOP853 took the step */
    double first;       /* size of the first coefficients but the constant, in tolerances */
    double further[2];  /* what the two last coefficients shrink by up to the degree that the end of the step misses */
    double contraction; /* of the last sweep */
    double
        along; /* part of the tolerance that the last sweep may change where it still changes more across the closure; else 0 */
    double grain;     /* rounding, in tolerances */
    double noise;     /* and of a velocity in its unit */
    int fresh;        /* whether this is the first step after a restart */
    int begun, ended; /* whether `begin` and `end` are known */
    int n, rows, lanes;
    double *f, *g;            /* [rows][STAGES] accelerations, and those of the next sweep */
    double *legendre;         /* [rows][STAGES] coefficients of the stage polynomial */
    double *q, *u, *du;       /* of one block [n][lanes] */
    double *time;             /* [lanes] */
    double *node;             /* [blocks][lanes] */
    double *once, *twice;     /* [blocks][STAGES][lanes] times the step's length, and its square */
    double *matrix;           /* [blocks][STAGES][lanes] */
    double *slope, *none;     /* [rows] the step's length times u; zeros */
    double *weight;           /* [n] of a change of acceleration, in tolerances */
    double *lost, *lost_next; /* [size] what rounding took from the state, at the start and at the end of the step */
    double *estimate;         /* [ESTIMATES][size] */
    double *start, *miss;     /* [size] for interpolation: the start, and end of the step less end of the polynomial */
    double *one;              /* [3 n] one state */
    double *dy, *dy1;         /* [size] derivatives */
    double *begin, *end;      /* [size] those at the start and at the end of the step */
    double *other;            /* scratch of DOP853 */
    double *side;             /* of system_acceleration_lanes */
};

/* out[i][STAGES] = sum over j of x[i][j] matrix[j], for all rows; the matrix packed by gauss_pack, in blocks of lanes */
void gauss_pack(const struct gauss *g, const double matrix[STAGES][STAGES], double factor, double *packed);
void gauss_combine(struct gauss *g, const struct system *s, const double *matrix, const double *x, double *out);

/* g->one = state at stage j along the motion that g->f gives */
void gauss_stage(struct gauss *g, int j, double h, const double *y);

/* The accelerations g->f of a step from (t, y), whose derivative is dy right after a restart; `converged` is 0 where sweeps
 * contract too slowly. Iterates to a part of the tolerance, or, where that is zero, until rounding is met. */
enum outcome gauss_solve(struct gauss *g, struct system *s, double t, double h, struct tolerance tolerance,
                         const double *y, const double *dy, int *converged);

/* Whether something may set in within a step: loads that have no potential, or switch. What follows from a smooth potential alone does not. */
static inline int gauss_has_loads(const struct system *s)
{
    return s->size > 2 * s->n || s->model->switches;
}

/* Compares the stage polynomial of the step with the accelerations at its ends: into the last two estimates. */
enum outcome gauss_look_at_ends(struct gauss *g, struct system *s, double t, double h, const double *y,
                                const double *y1);

/* What the step has not seen of its beginning and of its end, in tolerances */
double gauss_unseen(const struct gauss *g, int size, struct tolerance tolerance, const double *y, const double *y1);

/* weighted sum over the stages */
static inline double weighed(const double *weight, const double *x)
{
    return ((weight[0] * x[0] + weight[1] * x[1]) + (weight[2] * x[2] + weight[3] * x[3])) +
           ((weight[4] * x[4] + weight[5] * x[5]) + (weight[6] * x[6] + weight[7] * x[7]));
}

#endif
