/* States put onto a branch of the closure; see onto_branch.c. */
#ifndef CCGEN_ONTO_BRANCH_H
#define CCGEN_ONTO_BRANCH_H

#include "constraints/branch.h"

/* Put a state onto the system's branch, in place: driven joints stay where they are and as fast, held contacts are closed. NOT_CLOSED where no branch
 * passes there. */
enum outcome put_onto_branch(struct system *s, double *q, double *u);

#endif
