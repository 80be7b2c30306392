/* The record of a run, which grows; see record.c. */
#ifndef CCGEN_RECORD_H
#define CCGEN_RECORD_H

#include "constraints/active_set.h"

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

/* Append; 0, or 1 when memory runs out. Impulses are normal ones [count], then those of friction [count]. How
 * contacts are held is appended where it is not what it was. */
int append_row(struct record *record, double t, const double *y, size_t width);
int append_impact(struct impacts *impacts, double t, const double *u_minus, const double *u_plus, size_t n, int count,
                  const int *contact, const double *impulse, double energy_loss, size_t after);
int append_hold(struct holds *holds, double t, int contacts, const signed char *how, const struct holding *holding);

#endif
