/* Forces that keep held contacts closed; see contact_forces.c. */
#ifndef CCGEN_CONTACT_FORCES_H
#define CCGEN_CONTACT_FORCES_H

#include "constraints/active_set.h"
#include "constraints/nullspace.h"

/* Add to the accelerations of the free system what the held contacts do, each as much as its gap needs. Nonzero where they
 * nearly depend on each other or on the closure, or memory runs out, 2 where friction jams: the result is then not to be used. */
int add_contact_accelerations(struct system *s, const double *q, const double *u, double *u_dot);

/* The same where rows of the closure depend on each other, from the motions `flight` that those which count leave at q: u_dot[n] and the multipliers lambda[rows], both of
 * the free system before. The forces of the contacts are of least norm first, then the multipliers. `flight` is of jumps afterwards. */
int add_contact_accelerations_in_nullspace(struct system *s, const double *q, const double *u, struct nullspace *flight,
                                           double *u_dot, double *lambda);

/* Add to the jump du the impulses of the held contacts that bring the rates of their gaps, and with `speed` their sliding
 * where they stick, to wanted[rows] (m/s); nonzero likewise. */
int add_contact_jump(struct system *s, const double *q, int speed, const double *wanted, double *du);

#endif
