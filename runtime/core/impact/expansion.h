/* Expansion at several contacts, followed along the impulses; see expansion.c. */
#ifndef CCGEN_EXPANSION_H
#define CCGEN_EXPANSION_H

#include "base/arena.h"

/* n contacts with W[all][all], all = n, or 2 n where there is friction mu[n]; rates rate[all] at the end of compression, normals and
 * then tangents, and its impulses P[n], F[n]. Expansion changes these. */
struct expansion {
    int n, all;
    const double *W, *mu, *wanted, *goal;
    double *rate, *P, *F;
    struct arena *arena; /* for scratch */
};

/* Each contact pushes in proportion to wanted[n] (N s) until it has given back the work goal[n] (J), or nothing gives any back;
 * where `goal` is NULL, until it has pushed with wanted[n]. Returns 0; 1 when memory runs out. */
int expand(struct expansion *s);

/* times the impulses of compression, as they load the contacts: expansion ends there */
extern const double MOST;

#endif
