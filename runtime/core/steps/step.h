/* One step of a smooth phase: by which method, how large its error is, and its end put back onto the closure. */
#ifndef CCGEN_STEP_H
#define CCGEN_STEP_H

#include "constraints/active_set.h"
#include "constraints/branch.h"
#include "record/run.h"
#include "steps/event_search.h"

/* What a phase takes over from one step to the next, beside the state and what the method keeps */
struct progress {
    int under_way;       /* whether the phase has begun, and goes on */
    int crawled;         /* steps in a row that moved nothing */
    double crawls_since; /* when they began (s) */
    double since;        /* when it began */
    double next;         /* length of the step to try next */
    double late;         /* what rounding took from the time: many equal steps are as long as they say */
    int energy_known;    /* whether `energy` is that of the state */
    int bounded;         /* whether the step may not go on past its end, */
    double longest;      /* and the longest that there may be */
    double refused;      /* how long the next may be after one that could not end where it was to, or 0 */
    double energy[2],
        energy_end[2]; /* kinetic and potential, at y if it is known, and at the end of a step of length energy_h */
    double energy_h, energy_in_motion; /* and the largest energy that has been in motion */
    double meets;                      /* the longest step to try next, as the ends of a line are about to meet, or 0 */
    double stretch, stretch_end;       /* length and end of a step that was refused for the energy it missed */
    double widest;                     /* the farthest from dependence that rows have been seen, or 0 */
    int follows;                       /* whether the motion follows a branch of the closure, that of the phase */
    double seen; /* speed, of lengths in a characteristic time, above which no crowd and no jam brings to rest */
    double slow; /* speed below which contacts rest, off and along their grounds, where events crowd; 0: REST_SPEED */
};

struct phase {
    struct system *s;
    struct run *run;
    double t, h;
    double *y, *dy, *y1, *dy1; /* state and derivative at t, and at the end of the step */
    double *scratch;           /* of the run's method, */
    double *passing;           /* and of collocation, which takes its steps along branches if it damps, or NULL */
    struct branch branch;      /* of the closure, that the motion follows past a singular configuration */
    double *noted_place;       /* [2n + rows] branch.place, branch.heading and branch.offset before a step */
    const struct method *by;   /* that took the last step, */
    double *steps;             /* and its scratch */
    double *kept; /* what the method knew before a step, or knows now, on its way to or from the bytes of a state, */
    double *peak; /* and active.peak before a step */
    double *gaps, *rates; /* [contacts] where they were last looked at, for those that go on from there */
    int *met;             /* [contacts] events that each has had since its window of crowds began */
    int *tight; /* [contacts] events and impacts in a row between which each had no room that can be resolved */
    int *set; /* [contacts] those that strike, are held, or close where rows are lost, on their way from finding them */
    struct active_set active; /* of the system */
    double *sides;            /* [switches] of their kinks on which effects are in this phase */
    double *latched;          /* [latches] what they hold, NAN where nothing has been set */
    unsigned char events;     /* the eighths of the step in which events of the scene may be, as bits */
    int kink;                 /* number of the effect at whose kink the step ends, or -1 */
    int flips;                /* how often effects have changed sides at this instant */
    struct progress at;
};

/* speed, of lengths in a characteristic time, below which a closed contact neither opens nor closes */
double rest_speed(const struct phase *f);

/* and that speed (m/s); what loses nothing is not slowed down by crowds of events */
double rest_velocity(const struct phase *f, int contact);

/* Whether events that crowd may bring a closed contact to rest that moves at `rate` (m/s, rad/s) */
int may_rest(const struct phase *f, int contact, double rate);

/* A closed contact that moves at `rate` (m/s, rad/s) counts as at rest: where that is for events that crowd, the run tells how fast it was. */
void note_rest(struct phase *f, int contact, double rate);

/* gap (m, rad) below which a contact is closed */
double gap_tolerance(const struct phase *f, int contact);

/* dy at (t, y) */
enum outcome evaluate_derivative(struct phase *f);

/* whether the ends of steps are put back: onto the closure unless the run leaves that out, onto held contacts always */
int projects(const struct phase *f);

/* step of length h from (t, y) to y1, not put back yet */
enum outcome unprojected_step(struct phase *f, double h, struct tolerance tolerance);

/* Part of the velocities that is not known along a branch that passes a place by, rounding / sigma; 0 elsewhere */
double missed_velocity(const struct phase *f);

/* Have the motion follow the branch of the closure on which it is, from the state at t on: always, where rows are nearly dependent, or where they are, if it has. Its derivative is then that along the branch. It does not where no branch can be told. */
enum outcome follow_branch(struct phase *f);

/* Whether that failed because no branch is told: the closure as it is has to do */
int none_told(enum outcome outcome);

/* Whether rows are so near to dependence in state y that a branch is followed there: near in itself, and beside what they are elsewhere */
int is_beside_place(struct phase *f, const double *y);

enum outcome follow_if_beside(struct phase *f);
enum outcome keep_following(struct phase *f);

/* Have what is decided at an event be about the branch which the phase before has followed; the state is put onto it. */
enum outcome decide_on_branch(struct phase *f);

/* Have what strikes where two branches cross, or beside a place, keep to the one which the phase before has followed: the closure at the place would let it go along both. The state is put onto it. */
enum outcome strike_on_branch(struct phase *f);

/* Have it follow none; in the second, where its derivative was that along a branch, with that of the closure as it is. */
void leave_branch(struct phase *f);
enum outcome take_closure(struct phase *f);

/* what the error of the step to y1 amounts to; accepted up to 1. An error that fails is measured again without its part
 * across the closure, which projection removes: across a singular configuration that part is large and means nothing. Elsewhere
 * what is left may be small by chance, and so some of the whole counts. */
enum outcome step_error(struct phase *f, double *error);

/* record the present state, unless it is the last row already; 0, or 1 when memory runs out */
int record_state(struct phase *f);

/* have the last row hold what effects hold from now on, if it is of now: from there a motion goes on */
void record_latches(struct phase *f);

/* numbers of a row: those of the state, and what effects hold */
size_t row_width(const struct system *s);

/* the first time after t at which inputs have a kink, or infinity */
double next_kink(const struct run *run, double t);

/* the first time after t at which a step has to end: that, or the end of the run */
double next_stop(const struct run *run, double t);

/* put the end of a step back onto the closure and the held contacts; driven joints stay as prescribed: where the loops close only
 * without that, as beyond a dead point, they do not close */
enum outcome project_step_end(struct phase *f);

/* derivative at the end of the step, for methods that want it, or do after a step by another */
enum outcome evaluate_end_derivative(struct phase *f);

#endif
