/* What the files of the runtime's core share: the system that is integrated, its counters, and the outcome of a run. */
#ifndef CCGEN_CORE_H
#define CCGEN_CORE_H

#include "real.h"

#include "../model.h"

/* How a run or a step of it ended. Texts for people are made from these in Python. */
enum outcome {
    OUTCOME_DONE = 0,
    OUTCOME_NOT_FINITE,     /* an acceleration is not a finite number */
    OUTCOME_STEP_TOO_SMALL, /* the error test fails at the smallest step that still moves time */
    OUTCOME_NOT_CLOSED,     /* projection onto the closure does not converge */
    OUTCOME_ACCUMULATION,   /* events accumulate at one instant, and do not hand over to contact */
    OUTCOME_REPEATS,        /* impacts at one instant do not come to an end */
    OUTCOME_BUDGET,         /* step budget spent */
    OUTCOME_CROWDED,        /* the steps or events that a simulated second may have are spent */
    OUTCOME_JAMMED,         /* contacts with friction have no forces, or more than one choice of them (Painleve) */
    OUTCOME_GAINED,         /* an impact by this law would add energy */
    OUTCOME_ESCAPED,        /* a point gets behind its surface, however short the step */
    OUTCOME_INTERRUPTED,
    OUTCOME_NO_MEMORY,
    OUTCOME_NO_CONVERGENCE, /* the iteration of an implicit method does not converge */
    OUTCOME_NOT_KEPT,       /* a step of fixed length gains or loses too much of the energy */
    OUTCOME_INEXACT         /* masses differ so much that no digit of an acceleration or jump is sure */
};

/* How a run keeps the loops shut in flight. Projection is the way; the others are there for comparison. While contacts are
 * held, loops and contacts are projected in any case. */
enum drift { DRIFT_PROJECTED = 0, DRIFT_LEFT, DRIFT_DAMPED };

/* What restitution is a ratio of: speeds (Newton), impulses after and before the greatest compression (Poisson), or, squared,
 * the work that they do (Stronge) */
enum law { LAW_NEWTON, LAW_POISSON, LAW_STRONGE };

/* interruption.c: what a run asks the outside now and then */
struct interruption {
    int (*tick)(void *context, double t); /* a nonzero answer ends the run; may be NULL */
    void *context;
    double t;      /* how far the run is (s) */
    int64_t asked; /* when it was asked last, ns */
    long work;     /* done since the last look at the clock */
    int ended;     /* whether the answer was that the run is to end: it stays that */
};

/* From `t` on, where nothing has been asked. */
void start_asking(struct interruption *interruption, double t);

/* Ask at once; whether the run is to end. */
int ask(struct interruption *interruption);

/* A model with one set of parameters. y = [q; u] has 2 n entries, and one more, the work done by the effects that have no
 * potential and by friction in contacts, if the model has any. */
struct system {
    const struct ccgen_model *model;
    const double *k;           /* constants of the model */
    const double *restitution; /* per contact */
    const double *friction;    /* per contact, or NULL where all are smooth */
    int law;                   /* of impact: enum law */
    int n;                     /* nq = nu */
    int size;                  /* entries of y */
    double *inputs;            /* of the model, constant unless there is a supply */
    /* gives the inputs at a state, if set; a nonzero answer stops the run */
    int (*supply)(void *context, double t, const double *q, const double *u, double *inputs);
    void *context;             /* of the supply */
    struct interruption *interruption; /* of the run, or NULL */
    double *multipliers;       /* [rows + 2 contacts] scratch: of the last acceleration, or impulses */
    double *rows;              /* [rows + 2 contacts] scratch */
    double *bias;              /* [rows + 2 contacts] scratch of the robust path */
    double *jump;              /* [n] scratch */
    double *u_dot;             /* [3 n] scratch of system_power and system_derivative */
    double *zero;              /* [n] zeros: no generalized impulse */
    double *shut;              /* [2 n] scratch: a state put onto the closure */
    double missed;             /* by how much the last state put onto the closure missed it (m), */
    double missed_rate;        /* and its velocities (m/s) */
    double moved_rate;         /* and by how much that changed them (rad/s, and times length) */
    int guided;                /* whether derivatives are those of the state put onto the closure */
    double baumgarte;          /* rate (1/s) at which drift is damped by accelerations; 0: not that way */
    struct holding *holding;   /* contacts that stay closed, or NULL: contact.h */
    double length;             /* a length of the mechanism (m), the scale of closure */
    const double *extent;      /* per contact: the scale of its gap, `length` or, of an angle, 1 (rad) */
    int refine;                /* whether the elimination loses digits that are to be recovered: refine.h */
    double usual;              /* size of accelerations that are usual for it: less counts as that much in `inexact` */
    double inexact;            /* largest relative correction that did not become small, 0 if all did */
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

/* within.c: whether n numbers are all no larger than `limit` in size, to rounding, or finite; what is not a number is neither */
int all_within(size_t n, const double *x, double limit);
int all_finite(size_t n, const double *x);

/* Whether the run is to end; asked every hundredth of a second or two of computing, if this is called with the number of
 * freedoms wherever accelerations are worked out, and with 0 where more is done than that. */
int interrupted(struct system *s, long work);

/* u_dot[n], lambda[rows]; where the closure rows lose rank, by the robust path */
enum outcome system_acceleration(struct system *s, double t, const double *q, const double *u, double *u_dot,
                                 double *lambda);

/* lanes.c: u_dot of model->lanes states side by side, value i of lane l of t, q, u and u_dot at [i * lanes + l]; lanes that
 * lose rank take the robust path one by one. Numbers that are not finite are left to the caller. `scratch` has
 * lanes_scratch(s) numbers. */
enum outcome system_acceleration_lanes(struct system *s, const double *t, const double *q, const double *u, double *u_dot,
                                       double *scratch);
size_t lanes_scratch(const struct system *s);

/* whether the kernel over lanes has all that acts on the system; where it has not, states go one by one */
int lanes_apply(const struct system *s);

/* du[n], Lambda[rows] with M du = A^T Lambda + f, A du = y, likewise; on the robust path, rows nearer to the others than
 * `nearest` do not count */
enum outcome system_impulse(struct system *s, const double *q, const double *f, const double *y, double nearest,
                            double *du, double *Lambda);

/* du[n] without other impulses than those of the closure and of the held contacts, which bring the rates of the first and
 * the rates of the gaps of the second, with `speed` also the sliding of those that stick, to rows[rows + held]; `nearest`
 * as above */
enum outcome system_correction(struct system *s, const double *q, int speed, double *rows, double nearest, double *du);

/* How near closure rows come to dependence before one is left out: of the equations of motion, and of projection, where
 * a correction along a row that almost vanishes would be rounding made large */
extern const double NEAREST, NEAREST_PROJECTED;

/* power[1] of the effects that have no potential and of friction in contacts, for a system with an entry of work; what
 * driven joints take and how hard contacts push depends on the accelerations, which are solved for then */
enum outcome system_power(struct system *s, double t, const double *q, const double *u, double *power);

/* dy/dt = [u; u_dot]; of a guided system, of the nearest state on the closure */
enum outcome system_derivative(struct system *s, double t, const double *y, double *dy);

/* projection.c: nearest state on the closure, held contacts closed, in the metric of the mass matrix, position then
 * velocity, in place */
enum outcome project_position(struct system *s, double *q);
enum outcome project_velocity(struct system *s, const double *q, double *u);

/* complementarity.c: 0 <= P, 0 <= z = W P + b, P.z = 0 for symmetric positive semidefinite W[n][n].
 * Where W is singular the impulses of least norm are taken. Returns 0, or 1 when memory or iterations run out. */
int solve_complementarity(int n, const double *W, const double *b, double *P);

/* complementarity.c: x[n] of least norm with W x = r for symmetric positive semidefinite W[n][n] */
size_t semidefinite_scratch(int n);
void solve_semidefinite(int n, const double *W, const double *r, double *x, double *scratch);

/* x <- W^-1 x for symmetric W[n][n]; nonzero where it is not well away from losing rank */
int solve_definite_well(int n, const double *W, double *x, double *scratch);

/* impact.c: u_plus[n], P[2 count], normal impulses and then those of friction, for the contacts `set` struck together with
 * restitution e[count] by the system's law */
enum outcome impact(struct system *s, const double *q, const double *u_minus, int count, const int *set, const double *e,
                    double *u_plus, double *P);

#endif
