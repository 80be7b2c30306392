/* What a simulation consists of; ../../ccgen.h has its functions. */
#ifndef CCGEN_SIMULATION_H
#define CCGEN_SIMULATION_H

#include "hybrid/automaton.h"

#include "../../ccgen.h"

/* What a call has met: whether a contact had an event, how many impacts there were before that, and which event of the scene it ends at, or -1 */
struct met {
    int contact, indicator;
    size_t impacts;
};

/* How much is recorded; the last stretch of time stepping may go on, and is as it was then */
struct recorded {
    size_t rows, impacts, struck, modes, held, stretches, last;
    double t1, step, miss;
    long choices;
    size_t traced;
};

/* Where the last leg of a run that halts begins; see halting.c. */
struct leg {
    int goes_on; /* whether what comes next does so at the same instant, as what was done there brings it */
    char *state;
    struct recorded at;
    struct met met;
};

/* How much is recorded before the instant of a change, with the impacts of other joints at it, and the scales of the motion behind it */
struct origin {
    struct recorded at;
    size_t impact;
    double time, energy;
};

/* What events and joints have changed, in the order in which they did */
struct changes {
    size_t count; /* of those that were done, */
    size_t tried; /* and with those of the last instant that were not, as one of them could not be */
    size_t room;
    struct ccgen_change *of; /* [tried] */
    struct origin *origin;   /* [tried] */
    double *values;          /* [tried][parameters] behind each */
};

struct ccgen_simulation {
    struct system system;
    struct run run;
    struct phase phase;
    struct automaton automaton;
    struct arena arena;  /* all memory of the simulation but the record */
    double time;         /* its characteristic time as asked for (s), or 0 */
    char *before;        /* the state before a stage */
    struct watch *watch; /* for events of the scene, or NULL */
    /* what follows from the parameters: [constants], and [contacts] each */
    double *k, *restitution, *friction, *lever, *extent;
    int *on; /* [rows] of which the first `rows_on` of the system are set */
    double *k_held,
        *all_held; /* [constants], [parameters] if all joints held that let go or take hold; where some do */
    /* of a run that does what events say: the parameters of the settings, those before an event, what events set, and room for what effects hold */
    double *given, *kept, *event_values, *held;
    size_t crossing;      /* the number of that whose instant it is */
    double *was, *wanted; /* [parameters] before one event, and as it wants them */
    int (*on_event)(void *, const struct ccgen_crossing *, const double *, const double *, double *);
    void *event_context;
    const unsigned char *answered; /* [indicators] whether that is asked; NULL: always */
    struct leg leg;
    struct changes changes;
    int changed;    /* whether events have set any */
    long acted;     /* how often */
    int broken_off; /* whether it was interrupted on the way to an event at which it halts, and has not come there since */
};

struct recorded note_record(const struct run *run);
void cut_record(struct run *run, struct recorded at);

/* A row for where it has come, if that has none: `outcome`, or that memory has run out */
enum outcome record_end(struct ccgen_simulation *s, enum outcome outcome);

/* A call that goes on to `until`, or to an event, begins; goes on by one stage; ends with what it came to. */
enum outcome begin_call(struct ccgen_simulation *s, double until, int to_event, struct met *met);
enum outcome go_on_by_a_stage(struct ccgen_simulation *s, struct met *met);
enum outcome end_call(struct ccgen_simulation *s, enum outcome outcome);

/* Give a simulation other parameters, and the length, time and acceleration scale of `settings` that go with them; what else
 * they say is left. A run that has begun is over: reset it. */
void set_parameters(struct ccgen_simulation *s, const struct ccgen_settings *settings);

/* What follows from the parameters of a run that does what events say; and those of the settings again */
void derive_parameters(struct ccgen_simulation *it);
void forget_what_events_set(struct ccgen_simulation *it);

/* Motion begins anew from where it is, with what effects hold; the record goes on. */
enum outcome begin_anew(struct ccgen_simulation *it);

/* As ccgen_reset, before events are looked for */
enum outcome reset(struct ccgen_simulation *it, double t, const double *q, const double *u);

/* Whether events or joints of the scene do more than to be told */
int does_anything(const struct ccgen_model *m);

/* How the loops of a system are kept closed */
void keep_closed(struct system *s, enum drift drift);

/* A simulation that has its settings, and no scratch yet */
enum outcome make_simulation(struct ccgen_simulation *it, const struct ccgen_model *m,
                             const struct ccgen_settings *settings);
enum outcome reserve_scratch(struct ccgen_simulation *it);

/* A record of the present row alone, and of how contacts are held */
enum outcome begin_record(struct ccgen_simulation *it);

#endif
