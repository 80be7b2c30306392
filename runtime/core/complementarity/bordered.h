/* Which ways of rough contacts are worth solving, seen from a factorisation that ways with the same beginning share; see bordered.c. */
#ifndef CCGEN_BORDERED_H
#define CCGEN_BORDERED_H

#include "complementarity/coulomb.h"

/* What is known of all ways with the same beginning: their impulses can be told, or not, or none of them has impulses of its own */
enum beginning { SOUND, UNSOUND, SINGULAR };

/* The system of a way, contact by contact, as the product of a lower and an upper triangle. All is in units of the roots of compliances: impulses
 * as they load their contacts. */
struct bordered {
    double
        *slid; /* [2][n][2n] rates that normal impulses give with friction at the limit `against`, and at the other */
    double *alone, *held;      /* [n][2n] that they give without friction, and that friction gives */
    double *rate;              /* [2n] without impulses */
    double *lower, *upper;     /* [2n][2n] by rows, and by columns */
    double *y, *x;             /* [2n] right-hand sides behind the lower triangle; unknowns */
    double *impulse, *after;   /* [2n] impulses of a way, normals and then tangents, and the rates after them */
    const double **column;     /* [2n] of an unknown: the rates that it gives */
    int *row;                  /* [2n] of an unknown */
    int *before;               /* [n + 1] unknowns of the contacts before */
    enum beginning *beginning; /* [n + 1] of the contacts before */
};

/* 0, or 1 when memory runs out */
int take_bordered(const struct friction_problem *c, struct bordered *b);

/* Contact i, with what the way says of it, joins those before it; what is known then. */
enum beginning border(const struct friction_problem *c, const signed char *way, int i, struct bordered *b);

/* Whether impulses of the way, of which all contacts have joined, break the law, or load the contacts by more than `most`, by more than
 * rounding may do. */
int is_ruled_out(const struct friction_problem *c, const signed char *way, double most, const struct bordered *b);

#endif
