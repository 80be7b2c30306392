/* What the files of the runtime's core share: the system that is integrated, its counters, and the outcome of a run. */
#ifndef CCGEN_CORE_H
#define CCGEN_CORE_H

#include <stddef.h>

#include "../model.h"

/* How a run or a step of it ended. Texts for people are made from these in Python. */
enum outcome {
    OUTCOME_DONE = 0,
    OUTCOME_NOT_FINITE,     /* an acceleration is not a finite number */
    OUTCOME_STEP_TOO_SMALL, /* the error test fails at the smallest step that still moves time */
    OUTCOME_NOT_CLOSED,     /* projection onto the closure does not converge */
    OUTCOME_ACCUMULATION,   /* impacts accumulate at one instant */
    OUTCOME_SUSTAINED,      /* a contact stays closed */
    OUTCOME_REPEATS,        /* impacts at one instant do not come to an end */
    OUTCOME_BUDGET,         /* step budget spent */
    OUTCOME_INTERRUPTED,
    OUTCOME_NO_MEMORY
};

/* A model with one set of parameters. y = [q; u] has 2 n entries, and one more, the work done by the effects that have no
 * potential, if the model has any. */
struct system {
    const struct ccgen_model *model;
    const double *k;           /* constants of the model */
    const double *restitution; /* per contact */
    int n;                     /* nq = nu */
    int size;                  /* entries of y */
    double *inputs;            /* of the model, constant unless there is a supply */
    /* gives the inputs at a state, if set; a nonzero answer stops the run */
    int (*supply)(void *context, double t, const double *q, const double *u, double *inputs);
    void *context;             /* of the supply */
    double *multipliers;       /* [rows] of the last acceleration */
    double *rows;              /* [rows] scratch */
    double *bias;              /* [rows] scratch of the robust path */
    double *jump;              /* [n] scratch */
    double *zero;              /* [n] zeros: no generalized impulse */
    double length;             /* a length of the mechanism (m), the scale of gaps and of closure */
    long evaluations;
    long dependent; /* solutions that took the robust path */
};

/* supply.c: values over time, interpolated linearly, constant before the first row and after the last */
struct table {
    size_t count;
    int width;
    const double *t;      /* [count] times that grow */
    const double *values; /* [count][width] */
    size_t row;           /* where it was last looked at */
};
int supply_from_table(void *table, double t, const double *q, const double *u, double *inputs);

/* u_dot[n], lambda[rows]; where the closure rows lose rank, by the robust path */
enum outcome system_acceleration(struct system *s, double t, const double *q, const double *u, double *u_dot,
                                 double *lambda);

/* du[n], Lambda[rows] with M du = A^T Lambda + f, A du = y, likewise; on the robust path, rows nearer to the others than
 * `nearest` do not count */
enum outcome system_impulse(struct system *s, const double *q, const double *f, const double *y, double nearest,
                            double *du, double *Lambda);

/* How near closure rows come to dependence before one is left out: of the equations of motion, and of projection, where
 * a correction along a row that almost vanishes would be rounding made large */
extern const double NEAREST, NEAREST_PROJECTED;

/* dy/dt = [u; u_dot] */
enum outcome system_derivative(struct system *s, double t, const double *y, double *dy);

/* projection.c: nearest state on the closure in the metric of the mass matrix, position then velocity, in place */
enum outcome project_position(struct system *s, double *q);
enum outcome project_velocity(struct system *s, const double *q, double *u);

/* complementarity.c: 0 <= P, 0 <= z = W P + b, P.z = 0 for symmetric positive semidefinite W[n][n].
 * Where W is singular the impulses of least norm are taken. Returns 0, or 1 when memory or iterations run out. */
int solve_complementarity(int n, const double *W, const double *b, double *P);

/* impact.c: u_plus[n], P[count] for the contacts `set` struck together, with restitution e[count] by Newton's law */
enum outcome impact(struct system *s, const double *q, const double *u_minus, int count, const int *set, const double *e,
                    double *u_plus, double *P);

#endif
