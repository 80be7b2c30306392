/* Coulomb's law at rough contacts: what must hold of impulses; see coulomb.c. */
#ifndef CCGEN_COULOMB_H
#define CCGEN_COULOMB_H

#include "base/arena.h"

/* A problem of friction, as in friction.h, and what is asked of it again and again. */
struct friction_problem {
    int n;
    const double *W, *bn, *bt, *mu;
    const signed char *mode;
    const double *least; /* or NULL */
    double
        missed; /* what impulses may miss the law by where none meets it, as `coulomb_miss` counts; 0: NEARLY_CONSISTENT, as `coulomb_residual` does */
    const double
        *from; /* [2n] rates before, or NULL: where given, no impulses are looked for that add energy to them */
    struct arena *arena; /* for scratch */
    double *root; /* [2n] of the compliance of each row, normals and then tangents; 0 of one that no impulse moves */
    signed char
        *slides; /* [n] how a contact is known to slide: by mode[i], or as it does where no impulse moves it; else 0 */
    char *rough; /* [n] whether it has friction: none where it rests and no impulse moves it along its ground */
    double *
        against; /* [n] friction per normal impulse at one limit, -mu or mu: that against its sliding, or where it rests
                          * against the sliding of bt; 0 without friction */
};

/* Take root, slides, rough and against from the arena, and fill them from the rest; the caller gives them back with a mark of its
 * own. 0, or 1 when memory runs out. All below asks for it. */
int prepare_friction(struct friction_problem *c);

/* By how much impulses break the law, in parts of the sizes from which what is broken has been summed. */
double coulomb_residual(const struct friction_problem *c, const double *Pn, const double *Pt);

/* By how much they miss it, in parts of what approaches and of the least impulses: approach left, pull, friction beyond its limit, or short of it where a contact slides */
double coulomb_miss(const struct friction_problem *c, const double *Pn, const double *Pt);

/* Rate of a row, normals then tangents, and the size of its terms */
double rate_of(const struct friction_problem *c, int row, const double *Pn, const double *Pt, double *size);

/* In units of the root of an energy: the largest impulse as it loads its contact, the largest speed or least impulse that it comes from, and the larger of both */
struct sizes {
    double load, cause, speed;
};
struct sizes sizes_of(const struct friction_problem *c, const double *Pn, const double *Pt);

/* Rate of a row in parts of what its rounding is in parts of: of its terms, and of the largest of all rows. Where impulses all but cancel, as those that
 * hold a point of a light body along both its rows, these are far larger than what they come from; then no more of them counts than is rounding. */
double scaled_rate(const struct friction_problem *c, int row, const double *Pn, const double *Pt,
                   const struct sizes *of);

/* Rates[2n] that impulses give, normals and then tangents; 0 where they are rounding. */
void rates_after(const struct friction_problem *c, const double *Pn, const double *Pt, double *rates);

/* Normal impulses summed as they load their contacts, N s (m/s per N s)^(1/2), and what approaches in the same unit: what ends it
 * where each contact is alone and smooth. */
double loaded(const struct friction_problem *c, const double *Pn);
double approaching(const struct friction_problem *c);

/* What impulses come from, in that unit: what approaches, and in expansion the least impulses */
double caused(const struct friction_problem *c);

#endif
