/* Joints that let go and take hold: when they do, and how they take hold (docs/theory, section 5.15). */
#ifndef CCGEN_JOINT_CHANGES_H
#define CCGEN_JOINT_CHANGES_H

#include "interface/between.h"

/* Whether indicator i is looked for: events always are, a joint lets go only while it holds, and takes hold only while it is open. */
int is_looked_for(const struct ccgen_simulation *it, int i);

/* Whether it is looked for as a force, which comes at once where it is too large at first, or as a time */
int is_of_force(const struct ccgen_simulation *it, int i);
int is_of_time(const struct ccgen_simulation *it, int i);

/* value[indicators] of forces that are looked for <- the force in each joint less its limit (N), in a state of the run at t, under the contacts that are held
 * then, or if `before` an impact until then; NaN where no force is known */
enum outcome compare_forces(const struct ccgen_simulation *it, struct between *b, double t, int before, const double *q,
                            const double *u, double *value);

/* Whether the impact of the record of that number puts more than its limit into the joint that indicator i looks at */
enum outcome find_impulse(const struct ccgen_simulation *it, size_t impact, int i, int *passed);

/* Whether the points of the open joint that indicator i looks at are as near to each other at q as they have to be for it to take hold */
int is_near(const struct ccgen_simulation *it, int i, const double *q);

/* Whether indicator i is of a joint, not of an event of the scene */
int is_of_joint(const struct ccgen_simulation *it, int i);

/* The joint that indicator i looks at lets go, or takes hold, unless it has at this instant; *sets is whether it does. It takes hold in a plastic impact that is recorded: velocities
 * change, what is apart comes together, and joints whose limits its impulses pass let go, itself too. TOO_FAR where it is apart by more than it may be. Where this fails, what was
 * changed is left so. */
enum outcome change_joint(struct ccgen_simulation *it, int i, int *sets);

/* The same of the joint behind a gate, which becomes 1 or 0 as an event asks; how near its points have to be is as its first table that has it take hold says. */
enum outcome change_gate(struct ccgen_simulation *it, int gate, double held);

#endif
