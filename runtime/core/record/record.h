/* The record of a run, which grows; see record.c. */
#ifndef CCGEN_RECORD_H
#define CCGEN_RECORD_H

#include "constraints/active_set.h"

/* rows of the record: t[count], y[count][size of the state + latches] */
struct record {
    size_t count, room;
    double *t, *y;
    unsigned char *
        events; /* [count] the eighths of the step to each in which events of the scene may come, as bits, the first the lowest: what is not known is 1 */
    double told_from, told_to; /* the last step of which that is known, */
    unsigned char told;        /* and these */
};

/* impacts of a run, one after another; impact i has the contacts, impulses and those of friction first[i] .. first[i + 1] - 1 */
struct impacts {
    size_t count, room, contact_count, contact_room;
    double *t, *u_minus, *u_plus, *energy_loss;
    double *share; /* of their restitution that contacts had: less than 1 where all would gain, or has no impulses */
    size_t *first, *after; /* after: the row of the record right after the impact */
    int *contact;
    double *impulse, *friction;
};

/* the modes of closed contacts from when on: change i has the contacts first[i] .. first[i + 1] - 1, each with its enum
 * contact_mode */
struct mode_history {
    size_t count, room, contact_count, contact_room;
    double *t;
    size_t *first;
    int *contact;
    signed char *mode;
};

/* stretches of time stepping: from when, to when, by what steps at least, how far those may have missed, in units of the coordinates,
 * and their rows of the record, the first being where it began */
struct stepping {
    size_t count, room;
    double *t0, *t1, *step, *miss;
    size_t *first, *last;
    size_t jump_room;
    double *
        jump; /* [rows] of those after the first of a stretch the energy (J) that impulses of contacts added in the step to it */
};

/* Append; 0, or 1 when memory runs out. Impulses are normal ones [count], then those of friction [count]. How
 * contacts are held is appended where it is not what it was. */
int append_row(struct record *record, double t, const double *y, size_t size, const double *latched, size_t latches);
int append_impact(struct impacts *impacts, double t, const double *u_minus, const double *u_plus, size_t n, int count,
                  const int *contact, const double *impulse, double energy_loss, double share, size_t after);
int append_modes(struct mode_history *modes, double t, int contacts, const signed char *mode);

/* A stretch of time stepping begins, or goes on, at t, the last of `rows` rows; it has gone on by a step of length h to t, in which
 * impulses of contacts have added `jump` (J) to its energy. */
int open_stepping(struct stepping *stepping, double t, size_t rows);
int note_stepping(struct stepping *stepping, double t, double h, double miss, double jump, size_t rows);

#endif
