/* A run: flight and impact in turn, from a start to an end, everything recorded. */
#ifndef CCGEN_RUN_H
#define CCGEN_RUN_H

#include "method.h"

/* rows of the record: t[count], y[count][2 n] */
struct record {
    size_t count, room;
    double *t, *y;
};

/* impacts of a run, one after another; impact i has the contacts, impulses and those of friction first[i] .. first[i + 1] - 1 */
struct impacts {
    size_t count, room, contact_count, contact_room;
    double *t, *u_minus, *u_plus, *energy_loss;
    size_t *first, *after; /* after: the row of the record right after the impact */
    int *contact;
    double *impulse, *friction;
};

/* what was held from when on: change i has the contacts first[i] .. first[i + 1] - 1, held as how[] says: 1 slides backward,
 * 2 smooth, 3 slides forward, 4 sticks, 5 carried, 6 and 7 at the limit of friction, 8 touches without pressing; weight[] is
 * how much the friction of one that sticks bears */
struct holds {
    size_t count, room, contact_count, contact_room;
    double *t;
    size_t *first;
    int *contact, *how;
    double *weight;
};

struct holding;

struct run {
    /* asked for */
    double start, until;
    struct tolerance tolerance;
    const double *stops; /* [stop_count] times that grow, at which steps end: the right side has kinks there */
    size_t stop_count;
    double fixed_step; /* 0: steps chosen by the error estimate */
    long step_budget;   /* of the run */
    long second_budget; /* steps and events of one simulated second */
    const struct method *method;
    enum drift drift;
    struct interruption interruption; /* its `tick` and `context` */
    /* found */
    struct record record;
    struct impacts impacts;
    struct holds holds;
    enum outcome outcome;
    double t;            /* where it ended */
    int contact;         /* contact at fault, or -1 */
    long steps, rejected;
    double second;       /* when the present second began */
    long spent_before;   /* steps and events before that */
    long events;
};

/* Simulate from y[2 n] = [q; u], which is projected onto the closure first. Whatever the outcome, the record holds all that
 * was reached; free it with free_run. */
void simulate(struct system *s, struct run *run, double *y);
void free_run(struct run *run);

/* From y at t on by h, with the contacts `set` held, `slide` as in contact.h, projected as `drift` says: for states between
 * two rows of a record. One step of the method, or in a model without contacts as many as the tolerance, unless it is zero,
 * asks for. */
enum outcome advance(struct system *s, const struct method *method, struct tolerance tolerance, enum drift drift, double t,
                     double h, int count, const int *set, const signed char *slide, double *y);

/* record.c: append; 0, or 1 when memory runs out. Impulses are normal ones [count], then those of friction [count]. How
 * contacts are held is appended where it is not what it was. */
int append_row(struct record *record, double t, const double *y, size_t width);
int append_impact(struct impacts *impacts, double t, const double *u_minus, const double *u_plus, size_t n, int count,
                  const int *contact, const double *impulse, double energy_loss, size_t after);
int append_hold(struct holds *holds, double t, int contacts, const signed char *how, const struct holding *holding);

#endif
