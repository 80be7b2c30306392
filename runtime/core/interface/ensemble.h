/* Many runs of one model that differ in numbers: starts, parameters, inputs. Any number of threads work on an ensemble together;
 * what each run gives depends on its own numbers alone. */
#ifndef CCGEN_ENSEMBLE_H
#define CCGEN_ENSEMBLE_H

#include <stdatomic.h>

#include "interface/simulation.h"
#include "model/inputs.h"

/* Numbers of runs: those of run i begin at of + i * every, and every is 0 where all runs have the same. */
struct numbers {
    const double *of;
    size_t every;
};

/* How a run of an ensemble ended beside outcomes: it was not begun, or cannot begin with its numbers. */
enum { ROW_NOT_BEGUN = -1, ROW_REFUSED = -2 };

/* States at which the rounding of accelerations is measured for every run's parameters: places and speeds in units of the length, and
 * of the length or the radian, each per time. What is lost beyond `limit`, of the largest acceleration, is refined from then on. */
struct rounding_sample {
    size_t count;
    const double *q, *u;          /* [count][n] */
    const unsigned char *lengths; /* [n] which are lengths */
    double limit;
};

/* A number of a run's own from all its rows: t[rows], rows[rows][width], q and u first; out[] has as many as are asked for. */
typedef int (*run_reduction)(void *context, const double *t, const double *rows, size_t count, size_t width,
                             double *out);

struct ensemble {
    /* asked for */
    const struct ccgen_model *model;
    const struct ccgen_settings
        *settings; /* of all runs; of parameters and what follows from them where none are given */
    double until;
    size_t count;
    struct numbers q, u;             /* [n] each */
    struct numbers parameters;       /* [parameters], or NULL: those of the settings */
    struct numbers scales;           /* [2] with them: the length and the time of the settings */
    struct numbers inputs;           /* [own inputs], or NULL */
    const struct input_table *table; /* or inputs over time, of all runs; or NULL */
    int projections; /* how often a start is put onto the closure before the run does so; 0: it has been */
    double deepest;  /* starts deeper inside a ground than this, times the length, are refused */
    struct rounding_sample sample;
    size_t times;         /* states that are asked for, */
    const double *at;     /* [times] when; NULL: the one state at the end */
    size_t impact_times;  /* how many times of impacts are */
    run_reduction reduce; /* or NULL */
    void *context;
    size_t reduced;
    /* answers, of every run; NULL where not asked for */
    int *outcome, *contact;                          /* enum outcome, or as above; the contact at fault, or -1 */
    double *end;                                     /* [2 n + 1] q and u, and the time reached */
    long *steps, *impacts;                           /* rows of its record but the first; and impacts */
    double *impact_t;                                /* [impact_times], NAN behind the last */
    double *state;                                   /* [times][2 n], NAN after a run's end */
    double *pose, *velocity;                         /* [times][links][3] */
    double *point;                                   /* [times][points][2] */
    double *gap, *gap_rate;                          /* [times][contacts] */
    double *energy;                                  /* [times][2] */
    double *u_dot, *lambda, *push, *reaction, *told; /* [times] each as of held_forces; NAN where not known */
    double *reduction;                               /* [reduced] */
    /* the work */
    atomic_size_t next, done;
    atomic_int ended; /* whether runs are to end as they are */
};

/* Take one run after another until none is left, or `ended` is set; OUTCOME_NO_MEMORY where there is none to begin with. */
enum outcome work_on(struct ensemble *e);

/* Forget what was done, but for the answers. */
void begin_ensemble(struct ensemble *e);
void end_ensemble(struct ensemble *e);
size_t done_of(struct ensemble *e);

#endif
