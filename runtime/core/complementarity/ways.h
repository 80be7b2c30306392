/* Ways in which Coulomb's law can hold at rough contacts; see ways.c. */
#ifndef CCGEN_WAYS_H
#define CCGEN_WAYS_H

#include "complementarity/coulomb.h"

/* What a contact may do, in the order in which ways of equal impulses are preferred: it pushes or keeps its least impulse, and
 * its friction is against the sliding that it had (forward where it had none), holds it, or is the other way. */
enum { ON, HELD_FAST, BACK, LEAST_ON, LEAST_HELD, LEAST_BACK, KINDS };

/* Whether friction holds a contact of that kind, whatever it takes */
int holds_fast(int kind);

/* Friction per normal impulse of contact i whose friction is at a limit */
double at_limit(const struct friction_problem *c, int i, int kind);

/* The unknown impulses of a way, normals and then tangents, as column[m]; returns m. */
int unknowns_of_way(const struct friction_problem *c, const signed char *way, int *column);

/* Impulses of one way; 1 where they are not unique. A[2n][2n], x[2n] and column[2n] are scratch. */
int impulses_of_way(const struct friction_problem *c, const signed char *way, double *A, double *x, int *column,
                    double *Pn, double *Pt);

/* Impulses where contact i pushes as push[i] says, and its friction is at its limit backward (-1) or forward (1), or holds it
 * (0), from one linear system. Returns 0; 1 where it has no unique solution, or there is no memory. */
int impulses_of(const struct friction_problem *c, const char *push, const signed char *limit, double *Pn, double *Pt);

/* Impulses that are consistent to the last digits: what the rows of their way still miss is solved for once more, and again. How
 * friction compares with its limit does not enter, so it may be far below. */
void refine_impulses(const struct friction_problem *c, double *Pn, double *Pt);

#endif
