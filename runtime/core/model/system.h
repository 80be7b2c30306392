/* A model with one set of parameters, as the core computes with it: the system that is integrated, its counters, and where scratch is taken from. */
#ifndef CCGEN_SYSTEM_H
#define CCGEN_SYSTEM_H

#include "base/arena.h"
#include "base/interruption.h"
#include "base/outcome.h"
#include "base/real.h"

#include "../../model.h"

/* A model with one set of parameters. y = [q; u] has 2 n entries, and one more, the work done by the effects that have no
 * potential and by friction in contacts, if the model has any. */
struct system {
    const struct ccgen_model *model;
    const double *k;              /* constants of the model */
    const double *restitution;    /* per contact */
    const double *friction;       /* per contact, or NULL where all are smooth */
    const struct impact_law *law; /* of impact: impact/law.h */
    double law_missed; /* what impulses may miss Coulomb's law by where none meets it; 0 but in time stepping */
    int n;             /* nq = nu */
    int rows_on;       /* rows of the closure that are on, the others being zero and without multipliers: how many, */
    const int *on;     /* [rows_on] and which, in their order */
    int size;          /* entries of y */
    double *
        inputs; /* of the model, constant unless there is a supply; behind them the sides of effects and what they hold */
    const double *sides;   /* [switches] those that a step is on, or NULL: each state is on its own */
    const double *latched; /* [latches] what effects hold, NAN where nothing has been set; NULL where no run does so */
    /* gives the inputs at a state, if set; a nonzero answer stops the run */
    int (*input_source)(void *context, double t, const double *q, const double *u, double *inputs);
    void *context;                     /* of the supply */
    struct interruption *interruption; /* of the run, or NULL */
    struct arena *arena;               /* for scratch, which every function gives back at its end */
    double missed;                     /* by how much the last state put onto the closure missed it (m), */
    double missed_rate;                /* and its velocities (m/s) */
    double moved_rate;                 /* and by how much that changed them (rad/s, and times length) */
    int left_out;                      /* rows that were left out as that was done, for they all but depend on others */
    int projects_steps;                /* whether the ends of steps are */
    double baumgarte; /* rate, per characteristic time, at which drift is damped by accelerations; 0: not that way */
    struct branch *branch;        /* that states are put onto, or NULL: constraints/branch.h */
    struct active_set *active;    /* contacts that stay closed, or NULL: constraints/active_set.h */
    double length;                /* a length of the mechanism (m), the scale of closure */
    double time;                  /* its characteristic time (s): model/scales.h */
    double energy;                /* and energy (J) */
    const unsigned char *lengths; /* [n] whether a coordinate is a length (m), and not an angle */
    double *unit;                 /* [2 n + 1] of the entries of y: rad or length, each per time, energy */
    const double *extent;         /* per contact: the scale of its gap (m): `length` or, of an angle, that of 1 rad */
    const double *lever;          /* per contact, or NULL where no gap is an angle: model/contacts.h */
    int refine; /* whether the elimination loses digits that are to be recovered: constraints/refinement.h */
    double acceleration_scale;  /* size of accelerations that are usual for it: less counts as that much in `inexact` */
    double refinement_residual; /* largest relative correction that did not become small, 0 if all did */
    long evaluations;
    long rank_deficient; /* solutions that took the robust path */
};

/* on[] <- the rows of the closure that are on with these parameters, in their order: how many */
int find_rows_on(const struct ccgen_model *m, const double *parameters, int *on);

/* The largest entry of a motion x[n]: velocities in rad/s, or lengths of the mechanism per second, or accelerations likewise;
 * infinite where one is not a number. */
double fastest(const struct system *s, const double *x);

#endif
