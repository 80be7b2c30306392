/* Forces of held contacts that rigid bodies leave open; see shared_forces.c. */
#ifndef CCGEN_SHARED_FORCES_H
#define CCGEN_SHARED_FORCES_H

#include "complementarity/sharing.h"
#include "constraints/active_set.h"

/* Whether forces of what is held may be others than those of the last motion: these are open, some friction is at its limit where others keep the contact, or some
 * contact is carried */
int may_be_shared(const struct system *s);

/* push[2 contacts], normal forces (N, N m) and friction of what is held at (q, u), which moves with u_dot <- those of least norm that give the same u_dot within Coulomb's
 * limits, of contacts that are carried too, each block of contacts that move each other by itself; limits may be passed by the part `beyond` of the block's largest force, or
 * AS_GIVEN (sharing.h). NO_MEMORY, or REPEATS where they are not found; push is then as it was. With kept[contacts], zeros, not NULL, only blocks in which forces pass the law are
 * shared: kept is 1 of their contacts where that succeeds, and REPEATS is not said. */
enum outcome share_pushes(struct system *s, const double *q, const double *u, const double *u_dot, double beyond,
                          double *push, char *kept);

#endif
