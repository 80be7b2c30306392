/* The least of all impulses with which Coulomb's law holds; see least_impulses.c. */
#ifndef CCGEN_LEAST_IMPULSES_H
#define CCGEN_LEAST_IMPULSES_H

#include "complementarity/coulomb.h"

/* What is known: nothing; consistent impulses; or the motion too, which is theirs. */
enum known { NOTHING, IMPULSES, MOTION };

/* The consistent impulses of least normal ones, summed as they load their contacts, of all ways to stay, slide or leave that have
 * unique ones, and of Pn and Pt, where those are known. Where the motion is, ways are tried at those contacts alone that come to
 * rest with it. Returns 0; 1 where none are found; 2 where there are too many ways to try, or no memory. */
int least_impulses(const struct friction_problem *c, enum known given, double *Pn, double *Pt);

#endif
