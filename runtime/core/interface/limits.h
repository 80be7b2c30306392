/* What holds where closure rows are dependent: limits along the branch of the motion; see limits.c. */
#ifndef CCGEN_LIMITS_H
#define CCGEN_LIMITS_H

#include "model/system.h"

/* Evaluates a state: out[..] of it, as many entries as the groups have together */
typedef enum outcome evaluation(void *context, const double *q, const double *u, double *out);

/* Entries of an evaluation that are alike, whether they may be without bound where rows are dependent, and what is usual of them: what is far
 * smaller is rounding */
struct group {
    int count, unbounded;
    double usual;
};

/* Whether rows are so near to dependence at q[n] that an evaluation there has fewer digits than its limit, where there is one. `rank` is how many
 * rows count elsewhere, if that is known, else 0. */
int near_a_limit(struct system *s, const double *q, int rank);

/* out[..] at a state with near_a_limit: the limit of what `evaluate` gives along the branch of the motion. What has none is infinite, with the sign that
 * it has behind the place. *found is whether there is such a branch; *rank is then how many rows count beside the place. */
enum outcome limit_along_branch(struct system *s, const double *q, const double *u, const struct group *groups,
                                int count, evaluation *evaluate, void *context, int *rank, int *found, double *out);

#endif
