/* The place near which rows of the closure are dependent: where it lies, and whether loops close there; see place.c. */
#ifndef CCGEN_PLACE_H
#define CCGEN_PLACE_H

#include "constraints/chart.h"

/* Find the place near q[n], in units, and what it is: b->kind, and for motions that pass it by b->place and b->offset. What it is stays undecided where none is found. */
enum outcome find_place(struct system *s, struct branch *b, struct closed *c, const double *q);

/* No place is near any more. */
void forget_place(const struct system *s, struct branch *b);

/* Whether the place that was found last is near enough to q[n] to tell the branch there, rows being that far from dependence */
int stays_near_place(const struct system *s, const struct branch *b, const double *q, double margin);

/* How a motion goes through a place */
struct way_through {
    double *along; /* [n] of its velocities, in units, per unit of the fastest, the part that turns rows */
    double until;  /* the place is reached so many of them further, negative behind it */
    double turns;  /* how fast rows come back along it, 0 where it does not go through */
};

/* The way of a motion with velocities u[n] through the place near q[n], in units: it goes through, as far as rounding and its bend tell, where rows come to depend all at
 * once and loops close. */
enum outcome find_way_through(struct system *s, const struct branch *b, struct closed *c, const double *q,
                              const double *u, struct way_through *way);

#endif
