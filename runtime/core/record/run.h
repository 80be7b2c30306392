/* What a run is asked for and what it has found. */
#ifndef CCGEN_RUN_H
#define CCGEN_RUN_H

#include "base/interruption.h"
#include "methods/method.h"
#include "record/record.h"
#include "record/trace.h"

/* How a run keeps the loops shut in flight. Projection is the way; the others are there for comparison. While contacts are
 * held, loops and contacts are projected in any case. */
#define ALL_DRIFTS(X)                                                              \
    X(PROJECTED, "projected") /* what is usual */                                  \
    X(LEFT, "left")           /* the loops drift as the integration leaves them */ \
    X(DAMPED, "damped")       /* Baumgarte's stabilisation */

#define ENTRY(name, text) DRIFT_##name,
enum drift { ALL_DRIFTS(ENTRY) DRIFTS };
#undef ENTRY

/* What becomes of an impact that would gain energy, as Newton's law may with friction */
#define ALL_GAINS(X)                                                                    \
    X(REDUCES, "reduce") /* it has the largest part of its restitution that does not */ \
    X(STOPS, "stop")     /* the run stops before it */

#define ENTRY(name, text) GAIN_##name,
enum gain { ALL_GAINS(ENTRY) GAINS };
#undef ENTRY

struct run {
    /* asked for */
    double until;
    struct tolerance tolerance;
    const double *stops; /* [stop_count] times that grow, at which steps end: the right side has kinks there */
    size_t stop_count;
    double fixed_step; /* 0: steps chosen by the error estimate */
    long step_budget;  /* of the run */
    double duration;   /* how long the motion is meant to go on (s) */
    long rate_budget;  /* steps that get nowhere, and events, within a characteristic time: steps/pace.c */
    const struct method *method;
    enum gain on_gain;
    struct interruption interruption; /* its `tick` and `context` */
    int tells;                        /* whether events of the scene are asked for, */
    int watched;                      /* and there are any to look for */
    int halts;                        /* whether the run ends at such events, */
    int acts;                         /* or does what they say */
    double *values;                   /* [parameters] as events have set them; NULL of a run that does not */
    enum pause {
        GOES_ON,
        BEFORE_EVENTS, /* it pauses before a step that may hold one, */
        BEHIND_A_STEP  /* or behind the next step */
    } pauses;
    int paused; /* whether it has */
    /* found */
    struct record record;
    struct impacts impacts;
    struct mode_history modes;
    struct stepping stepping;
    struct trace trace;
    enum outcome outcome;
    int contact; /* contact at fault, or -1 */
    long steps, rejected;
    long taken_before;  /* of them, before this call */
    double paced_since; /* when the present stretch of steps began, in this call */
    long paced_from;    /* and how many steps there were */
    int paced;          /* whether this call is meant to come to its end */
    double window;      /* when the present one began */
    long spent_before;  /* steps and events before that, and those since that get on */
    long events;
    double rest_speed; /* m/s: the fastest that counted as at rest as events crowded or friction jammed, or 0 */
    long choices;      /* at how many recorded instants contacts could as well have stayed as left, and have left */
    double chosen_at;  /* when the first of these was; nothing without one */
};

void free_run(struct run *run);

#endif
