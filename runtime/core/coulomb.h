/* Coulomb's law at rough contacts: what must hold of impulses, and all ways in which it can; see coulomb.c. */
#ifndef CCGEN_COULOMB_H
#define CCGEN_COULOMB_H

#include "real.h"

/* A problem of friction, as in friction.h. */
struct rough {
    int n;
    const double *W, *bn, *bt, *mu;
    const signed char *slide;
    const double *least; /* or NULL */
};

/* By how much impulses break the law, in parts of the sizes from which what is broken has been summed. */
double broken(const struct rough *c, const double *Pn, const double *Pt);

/* What is left of the law where it is met; more than rounding leaves of some dozens of pivots */
extern const double CONSISTENT;

/* How contact i is known to slide: as slide[i] says, or as it does where no impulse moves it along its ground; else 0. */
int sliding(const struct rough *c, int i);

/* Whether it has friction: none where it rests and no impulse moves it along its ground. */
int rough_at(const struct rough *c, int i);

/* Rates[2n] that impulses give, normals and then tangents; 0 where they are rounding. */
void rates_after(const struct rough *c, const double *Pn, const double *Pt, double *rates);

/* Impulses where contact i pushes as push[i] says, and its friction is at its limit backward (-1) or forward (1), or holds it
 * (0), from one linear system. Returns 0; 1 where it has no unique solution, or there is no memory. */
int impulses_of(const struct rough *c, const char *push, const signed char *limit, double *Pn, double *Pt);

/* The consistent impulses of least normal ones, summed as they load their contacts, of all ways to stay, slide or leave that have
 * unique ones. Where `known`, Pn and Pt are consistent, and ways are tried at those contacts alone that come to rest with them:
 * better ones replace them. Returns 0; 1 where none are found; 2 where there are too many ways to try, or no memory. */
int least_impulses(const struct rough *c, int known, double *Pn, double *Pt);

#endif
