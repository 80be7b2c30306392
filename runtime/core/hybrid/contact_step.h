/* One step of time stepping; see contact_step.c. */
#ifndef CCGEN_CONTACT_STEP_H
#define CCGEN_CONTACT_STEP_H

#include "steps/step.h"

/* What a step works with */
struct step_room {
    double *middle, *dy;    /* [size] state in the middle, and its derivative */
    double *free, *u;       /* [n] velocities after the step without contacts, and with them */
    double *momentum;       /* [n] scratch */
    double *before, *after; /* [contacts] rates of the gaps before the step, or an impact, and scratch */
    double *e, *less;       /* [contacts] restitution */
    double *P;              /* [2 contacts] */
    double scale;           /* energy (J) of the heaviest coordinate at a speed of its unit */
    double jump;   /* J: what impulses of contacts, and of driven joints at them, have added in a try, and in a step */
    double *from;  /* [size] where a piece of a step begins */
    double *whole; /* [size] end of a whole step */
    double *half;  /* [size] end of its first half */
    int *held;     /* [contacts] those that are pressed, and stay on their grounds */
    int *put;      /* [contacts] those that are put back onto them */
    signed char *mode; /* [contacts] how: without friction */
};

/* Its arrays, from the arena of the system; 0, or 1 when memory runs out. */
int take_step_room(const struct system *s, struct step_room *r);

/* One step of length h from (t, y) to y1, in pieces where the whole is too long: what comes to rest on its way up has no speed left for the half of a step. What hardly moves, and
 * finds no such piece, stays for the rest of the step. r->jump is that of the step. */
enum outcome step_once(struct phase *f, struct step_room *r, double t, double h, const double *y, double *y1);

#endif
