/* Forces that keep held contacts closed; see contact_forces.c. */
#ifndef CCGEN_CONTACT_FORCES_H
#define CCGEN_CONTACT_FORCES_H

#include "constraints/active_set.h"

/* Add to the accelerations of the free system what the held contacts do, each as much as its gap needs. Nonzero where they
 * nearly depend on each other or on the closure, or memory runs out, 2 where friction jams: the result is then not to be used. */
int add_contact_accelerations(struct system *s, const double *q, const double *u, double *u_dot);

/* Add to the jump du the impulses of the held contacts that bring the rates of their gaps, and with `speed` their sliding
 * where they stick, to wanted[rows] (m/s); nonzero likewise. */
int add_contact_jump(struct system *s, const double *q, int speed, const double *wanted, double *du);

#endif
