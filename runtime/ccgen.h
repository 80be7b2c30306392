/* A model's motions from C: a simulation goes from event to event, and its state can be taken out, kept and put back.
 *
 * Numbers are in SI units. Functions that can fail return 0, or a code whose name ccgen_outcome_name gives; what a simulation has
 * reached is kept in any case. One simulation is for one thread at a time; different ones may run side by side.
 * docs/c.md tells how to compile this with a model.
 */
#ifndef CCGEN_H
#define CCGEN_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

#include "model.h"

#if defined(CCGEN_SHARED) && defined(__GNUC__) /* in a library whose other names are hidden */
#define CCGEN_PUBLIC __attribute__((visibility("default")))
#else
#define CCGEN_PUBLIC
#endif

/* Where an event indicator of the scene comes to zero: its number, and whether it rises, 1, or falls, -1 */
struct ccgen_crossing {
    double t; /* s */
    int indicator, direction;
};

/* A model with its parameters, and how its motions are integrated. What is 0 or NULL is chosen as said. Arrays, and `context`,
 * have to stay as long as the simulation, but for `parameters`, `lengths` and `angular`. */
struct ccgen_settings {
    const double *parameters; /* [parameters] in the order of the model's data; NULL only for a model that has none */
    double length; /* a length of the mechanism (m), as the largest of its links: the scale of what counts as shut; 1 */
    double
        time; /* its characteristic time (s), as half a swing of a pendulum of that length: the scale of what counts as an
                    instant or as rest. 0: told by how the motion begins, half a turn at its largest rate or at the root of its largest
                    acceleration */
    double duration; /* how long the motion is meant to go on (s): the longest that its time is if it is told so; 1 */
    const unsigned char
        *lengths; /* [nq] whether each coordinate is a length (m); NULL: the first are, those of the place
                                     of a floating root, and all others are angles */
    const unsigned char *angular; /* [contacts] whether each is a stop of an angle; none */
    const char *law;              /* of impact, a name in core/impact/all_laws.h; newton */
    double acceleration_scale; /* accelerations that are usual (rad/s^2): they are refined to full digits, as masses far
                                   * apart want it; 0: not */
    const char *method;        /* a name in core/methods/all_methods.h; NULL: gauss */
    double rtol, atol;         /* tolerances; 1e-9, and as rtol. atol is in rad, times `length` of lengths, both per
                                  characteristic time of velocities */
    double fixed_step;         /* s; 0: as the tolerances ask for, which only a method that estimates its errors can */
    int drift;                 /* how loops are kept shut, a number that ccgen_drift_name names; 0: by projection */
    int on_gain;      /* what becomes of an impact that would gain energy, a number that ccgen_gain_name names; 0: it
                                  has the largest part of its restitution that does not */
    long step_budget; /* steps in all; ten million */
    /* steps that get nowhere, and events, within a characteristic time, or a tenth of the duration; 200,000. With fewer, slow contacts come to rest
     * sooner where events crowd: from a two-hundredth of these events on (docs/events.md). */
    long rate_budget;
    const double *stops; /* [stop_count] times that grow, at which steps end: where inputs have kinks */
    size_t stop_count;
    int events; /* what becomes of events of the scene: CCGEN_IGNORE, CCGEN_TELL (ccgen_crossings; the motion is the same by every bit), CCGEN_HALT: motion
                 * is told of and ends at each, or CCGEN_ACT: at those that do something, which is done then: they set parameters, switch effects on and
                 * off, have joints let go or take hold, or end the motion */
    /* with CCGEN_ACT, what the program itself does at events of the scene; NULL: nothing. Asked at each event, with q[nq] and u[nu] there, behind what the event sets. It may write into
     * parameters[parameters], which hold from then on, and answers one of the numbers below; any other interrupts the motion, before the event, to which it comes again. */
    int (*on_event)(void *context, const struct ccgen_crossing *event, const double *q, const double *u,
                    double *parameters);
    void *event_context;
    const unsigned char *answered; /* [indicators] at which events it is asked; NULL: at all */
    /* the model's inputs[inputs] at a state; NULL: all are 0. A nonzero answer interrupts the motion. */
    int (*inputs)(void *context, double t, const double *q, const double *u, double *inputs);
    void *context;
    /* asked several times a second how far the motion is; a nonzero answer interrupts it; may be NULL */
    int (*tick)(void *context, double t);
    void *tick_context;
};

enum { CCGEN_IGNORE, CCGEN_TELL, CCGEN_HALT, CCGEN_ACT };

enum {
    CCGEN_GO_ON, /* with what on_event has written, if it has */
    CCGEN_END,   /* and the motion ends there */
    CCGEN_REFUSE /* what the event asks for cannot be: the motion ends there, and nothing is set */
};

enum ccgen_event_kind {
    CCGEN_NO_EVENT, /* the time asked for is reached */
    CCGEN_CLOSES,   /* a contact has closed, and strikes unless it only touches */
    CCGEN_CHANGES,  /* a held contact opens, or begins or ends to slide */
    CCGEN_JAMS,     /* friction jams: an impact without collision */
    CCGEN_CROSSES,  /* an event of the scene comes; `contact` tells of one that has an event at that instant too */
    CCGEN_ENDS      /* so does one by which the scene has the motion end; it may go on, and counts from 1 then */
};

struct ccgen_event {
    enum ccgen_event_kind kind;
    double t;       /* s */
    int contact;    /* its number, or -1 */
    size_t impacts; /* how many followed at once */
    int indicator;  /* the number of the scene's event, or -1 */
};

struct ccgen_simulation;

/* A simulation of a model, which has to stay as long: nothing has begun. */
CCGEN_PUBLIC int ccgen_create(const struct ccgen_model *model, const struct ccgen_settings *settings,
                              struct ccgen_simulation **simulation);

/* Begin at time t from q[nq], u[nu], which are put onto the closure. What was recorded before is forgotten. Where settings tell no
 * time, the inputs at the start are asked for. */
CCGEN_PUBLIC int ccgen_reset(struct ccgen_simulation *simulation, double t, const double *q, const double *u);

/* Go on to the next event and past it, with its impacts and the choice of the contacts that are held then, or to `until`. */
CCGEN_PUBLIC int ccgen_step_to_event(struct ccgen_simulation *simulation, double until, struct ccgen_event *event);

/* Time, q[nq] and u[nu] that are reached; any may be NULL */
CCGEN_PUBLIC void ccgen_get_motion(const struct ccgen_simulation *simulation, double *t, double *q, double *u);

/* The model's constants k[constants] with the parameters of the simulation: what its other functions read, as `energy` */
CCGEN_PUBLIC const double *ccgen_get_constants(const struct ccgen_simulation *simulation);

/* The parameters[parameters] that are in force, with what events have set; NULL without CCGEN_ACT. They stay where they are. */
CCGEN_PUBLIC const double *ccgen_get_parameters(const struct ccgen_simulation *simulation);

/* Accelerations u_dot[nq] of the model at a state, in flight: whatever contacts are closed, they do not push. They are by the
 * inputs[inputs] given, or by those that the settings supply where `inputs` is NULL. What the simulation has reached stays. */
CCGEN_PUBLIC int ccgen_find_acceleration(struct ccgen_simulation *simulation, double t, const double *q, const double *u,
                                    const double *inputs, double *u_dot);

/* The same, and what they change by, row by row: by_q[nq][nq], by_u[nq][nq] and by_inputs[nq][inputs], any of which may be NULL.
 * The model has to be generated with its derivatives. Where closure rows depend on each other there are none by coordinates. */
CCGEN_PUBLIC int ccgen_derive_acceleration(struct ccgen_simulation *simulation, double t, const double *q,
                                             const double *u, const double *inputs, double *u_dot, double *by_q,
                                             double *by_u, double *by_inputs);

/* How each contact is held, modes[contacts]: numbers that ccgen_mode_name names */
CCGEN_PUBLIC void ccgen_get_modes(const struct ccgen_simulation *simulation, signed char *modes);

/* The whole state as bytes. Put back, also into another simulation of the same model, method and settings, motion goes on by
 * the same bits, but for which events of the scene are still to come, and how often they have. ccgen_set_state refuses, and changes nothing, where the state is of another model, method or precision;
 * what was recorded before is forgotten. A state is for the same kind of processor. */
CCGEN_PUBLIC size_t ccgen_state_size(const struct ccgen_simulation *simulation);
CCGEN_PUBLIC void ccgen_get_state(const struct ccgen_simulation *simulation, void *bytes);
CCGEN_PUBLIC int ccgen_set_state(struct ccgen_simulation *simulation, const void *bytes);

/* Rows that are recorded, one for the start, for every step, for every choice of contacts that moves the state and where motion begins anew behind changes, two for every impact: their times t[rows], and the rows themselves, each with
 * *width numbers, q and u first and what effects hold last. They stay where they are until the simulation goes on. */
CCGEN_PUBLIC size_t ccgen_rows(const struct ccgen_simulation *simulation, const double **t, const double **rows,
                               size_t *width);

/* Those up to the last row, in the order of time, as far as `directions` of the model ask for them: *count, and states[count][2 nq] there,
 * q first. They stay where they are until the next call, and are forgotten by ccgen_reset and ccgen_set_state. An indicator that is at or beyond zero where a
 * motion begins has to go below first. Only with `events` of the settings. */
CCGEN_PUBLIC int ccgen_crossings(struct ccgen_simulation *simulation, size_t *count,
                                 const struct ccgen_crossing **crossings, const double **states);

/* What an event of the scene has set, or a joint that has let go or taken hold */
struct ccgen_change {
    double t;      /* s */
    int indicator; /* the number of the event, or of the joint's table behind the events; -1: on_event asked for it */
    int gate;      /* of a joint the number of the parameter that is 1 while it holds; -1 of what an event sets */
    double energy; /* what the mechanism got by it (J); of a joint that takes hold, as its points were drawn together, */
    double gap;    /* which were so far apart (m) */
    size_t crossing; /* by which crossing it came; of a joint that breaks, that by which another took hold */
    size_t row;      /* from which row on it holds */
};

/* Those up to now, in the order in which they came: *count, and parameters[count][parameters] behind each. They stay where they are until the simulation goes on, and
 * are forgotten with the rows. Only with CCGEN_ACT. */
CCGEN_PUBLIC int ccgen_changes(const struct ccgen_simulation *simulation, size_t *count,
                               const struct ccgen_change **changes, const double **parameters);

/* Forget what is recorded but the present row: for motions that go on for long. */
CCGEN_PUBLIC int ccgen_forget(struct ccgen_simulation *simulation);

/* The name of a code, as "done" or "step_too_small" */
CCGEN_PUBLIC const char *ccgen_outcome_name(int code);

/* How a contact is held in words, as "sticks" or "apart"; NULL of a number that is no mode */
CCGEN_PUBLIC const char *ccgen_mode_name(int mode);

/* How loops are kept shut, in a word: "projected", "left" as the integration leaves them, or "damped" by Baumgarte's stabilisation;
 * NULL of a number that is no way to do that */
CCGEN_PUBLIC const char *ccgen_drift_name(int drift);

/* What becomes of an impact that would gain energy, in a word: "reduce" its restitution, or "stop" the run; NULL of a number that is neither */
CCGEN_PUBLIC const char *ccgen_gain_name(int gain);

CCGEN_PUBLIC void ccgen_destroy(struct ccgen_simulation *simulation);

#ifdef __cplusplus
}
#endif

#endif
