/* Coulomb's law at rough contacts: what must hold of impulses, and all ways in which it can; see coulomb.c. */
#ifndef CCGEN_COULOMB_H
#define CCGEN_COULOMB_H

#include "base/arena.h"

/* A problem of friction, as in friction.h, and what is asked of it again and again. */
struct friction_problem {
    int n;
    const double *W, *bn, *bt, *mu;
    const signed char *mode;
    const double *least; /* or NULL */
    const double
        *from; /* [2n] rates before, or NULL: where given, no impulses are looked for that add energy to them */
    struct arena *arena; /* for scratch */
    double *root;        /* [2n] of the compliance of each row, normals and then tangents */
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

/* Rates[2n] that impulses give, normals and then tangents; 0 where they are rounding. */
void rates_after(const struct friction_problem *c, const double *Pn, const double *Pt, double *rates);

/* Impulses where contact i pushes as push[i] says, and its friction is at its limit backward (-1) or forward (1), or holds it
 * (0), from one linear system. Returns 0; 1 where it has no unique solution, or there is no memory. */
int impulses_of(const struct friction_problem *c, const char *push, const signed char *limit, double *Pn, double *Pt);

/* Normal impulses summed as they load their contacts, N s (m/s per N s)^(1/2), and what approaches in the same unit: what ends it
 * where each contact is alone and smooth. */
double loaded(const struct friction_problem *c, const double *Pn);
double approaching(const struct friction_problem *c);

/* Impulses that are consistent to the last digits: what the rows of their way still miss is solved for once more, and again. How
 * friction compares with its limit does not enter, so it may be far below. */
void refine_impulses(const struct friction_problem *c, double *Pn, double *Pt);

/* What is known: nothing; consistent impulses; or the motion too, which is theirs. */
enum known { NOTHING, IMPULSES, MOTION };

/* The consistent impulses of least normal ones, summed as they load their contacts, of all ways to stay, slide or leave that have
 * unique ones, and of Pn and Pt, where those are known. Where the motion is, ways are tried at those contacts alone that come to
 * rest with it. Returns 0; 1 where none are found; 2 where there are too many ways to try, or no memory. */
int least_impulses(const struct friction_problem *c, enum known given, double *Pn, double *Pt);

#endif
