/* What is to be known to decide which closed contacts are held; see decision.c. */
#ifndef CCGEN_DECISION_H
#define CCGEN_DECISION_H

#include "algebra/semidefinite.h"
#include "hybrid/vanishing.h"

/* A smaller problem */
struct part {
    int *row;                 /* [2 contacts] the rows that it has */
    double *W, *b, *x, *mu;   /* [2 contacts]^2, [2 contacts], [2 contacts], [contacts] */
    signed char *mode;        /* [contacts] */
    struct semidefinite room; /* for 2 contacts */
};

struct decision {
    int count, all;     /* closed contacts in question; rows: twice as many where there is friction */
    int *contact;       /* [count] */
    char *in;           /* [count] takes part */
    signed char *mode;  /* [count] 0 where that is to be found */
    char *given;        /* [count] friction has just reached a limit: what is near it has reached it */
    char *touches;      /* [count] held although it does not push: nor does it move */
    int *twin;          /* [count] the candidate that bears in place of one that touches as it does, or -1 */
    char *stands;       /* [count] closed, and stays so whatever contacts do: no motion changes its gap */
    double *b;          /* [all] accelerations of the gaps, and of the sliding, without the forces */
    double *P, *W;      /* [all], [all][all] */
    double *trial;      /* [all] forces without one of the contacts */
    struct part part;   /* the problem of some of the contacts */
    signed char *modes; /* [contacts] how those that stay are held, in their order */
    const double *mu;   /* of all contacts */
    double scale;       /* the largest acceleration of a gap, or a small part of that of the links */
    double
        enlarged; /* by what b is enlarged, where all that presses has vanished and what decides is small against `scale` */
    const char
        *moves; /* [contacts] whether its sliding is no rest although it is slow: it could not be taken away; or NULL */
    const char
        *opens; /* [contacts] whether it opens slowly, but is not to be held: others could not rest with it; or NULL */
    int events_crowd;        /* events follow each other without time */
    signed char *was;        /* [contacts] how they were held before */
    int chosen;              /* contacts that could as well have stayed, and leave */
    struct mode_change loss; /* what has just ended */
    struct vanishing vanishing;
};

/* A decision's arrays from the arena of the system; 0, or 1 when memory runs out. */
int take_decision(struct decision *d, struct system *s);

/* The closed contacts that are slow enough to ask, and what they need to know; d->loss and d->vanishing are given. */
enum outcome gather_candidates(struct phase *f, struct decision *d);

#endif
