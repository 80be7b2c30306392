/* Forces that rigid bodies leave open: those of least norm that Coulomb's law allows; see sharing.c. */
#ifndef CCGEN_SHARING_H
#define CCGEN_SHARING_H

#include "base/arena.h"

/* Contacts that push with forces that keep the law, and by which nothing but the forces is to change */
struct shared {
    int n;                   /* contacts */
    int rows;                /* n, or where there is friction 2 n: normals, then tangents */
    const double *W;         /* [rows][rows] accelerations of the rows that unit forces along them give */
    const double *mu;        /* [n] */
    const signed char *side; /* [n] friction is -side mu P where that is not 0, else within its limits */
    const char *leaves;      /* [n] whether a contact opens, and so has no force */
    struct arena *arena;
};

/* P[rows] <- the forces of least norm that give the accelerations W P that P gives, push, and keep Coulomb's law. P stays as it is where there are no others, and
 * where memory runs out. */
void share_forces(const struct shared *c, double *P);

#endif
