/* Forces that rigid bodies leave open: those of least norm that Coulomb's law allows; see sharing.c. */
#ifndef CCGEN_SHARING_H
#define CCGEN_SHARING_H

#include "base/arena.h"
#include "base/outcome.h"

#define AS_GIVEN (-1.0) /* limits may be passed as far as the forces that are given pass them */

/* Contacts that push with forces that keep the law, and by which nothing but the forces is to change */
struct shared {
    int n;                   /* contacts */
    int rows;                /* n, or where there is friction 2 n: normals, then tangents */
    const double *W;         /* [rows][rows] accelerations of the rows that unit forces along them give */
    const double *mu;        /* [n] */
    const signed char *side; /* [n] friction is -side mu P where that is not 0, else within its limits */
    const char *leaves;      /* [n] whether a contact opens, and so has no force */
    double beyond;           /* how far limits may be passed, as a part of the largest force, or AS_GIVEN */
    struct arena *arena;
};

/* P[rows] <- the forces of least norm that give the accelerations W P that P gives, push, and keep Coulomb's law but for what may be `beyond` it. P stays as it is where there are no
 * others, which is so too where rows nearly depend on each other: digits of W do not tell then what gives the same. It stays where memory runs out, and where the search
 * does not end (OUTCOME_REPEATS), which it does but for rounding. Where limits may not be passed AS_GIVEN, OUTCOME_REPEATS says too that none are within them. */
enum outcome share_forces(const struct shared *c, double *P);

#endif
