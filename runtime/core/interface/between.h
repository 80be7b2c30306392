/* States of a run between the rows of its record; see between.c. */
#ifndef CCGEN_BETWEEN_H
#define CCGEN_BETWEEN_H

#include "interface/advance.h"

/* Scratch of one look between rows; the state is in y */
struct look {
    double *y, *other; /* [size of a state] */
    double *curve;     /* [n] */
};

/* The state at t between the rows, as accurate as the run, into l->y. */
enum outcome state_between(const struct stretch *w, const struct look *l, double t);

/* Scratch for states of a simulation between its rows, from its arena */
struct between {
    struct look look;
    double *latched;   /* [latches] what effects hold at the state that was asked for last */
    double *unit;      /* [2 n + 1] */
    int *set;          /* [contacts] what is held there, */
    signed char *mode; /* [contacts] and how */
    int count;
};

/* 0, or 1 when memory runs out */
int take_between(struct ccgen_simulation *s, struct between *b);

/* The state q[n], u[n] of the run at t, within its record, as accurate as the run: after an impact at its time. */
enum outcome state_at(const struct ccgen_simulation *s, struct between *b, double t, double *q, double *u);

/* The contacts that are held at t, into b->set and so on; those that others carry too, unless `pushing` alone are asked for. */
void held_at(const struct ccgen_simulation *s, struct between *b, double t, int pushing);

/* What effects hold at t, into b->latched */
void latched_at(const struct ccgen_simulation *s, struct between *b, double t);

/* Whether the run went on by time stepping at t: what pushes there is not known. */
int stepped_at(const struct ccgen_simulation *s, double t);

#endif
