/* On which sides of their kinks effects are in a phase, and what they hold since they came there (docs/theory, section 5.12). */
#ifndef CCGEN_KINKS_H
#define CCGEN_KINKS_H

#include "steps/step.h"

/* Put the effects on the sides of their kinks to which the motion goes from f->y, forward (1) or backward in time (-1); they are held there until the system's `sides` are NULL
 * again. */
enum outcome hold_sides(struct phase *f, int direction);

/* The same forward where a phase begins; what effects hold is set that have come to their side without a step that ended there. */
enum outcome begin_sides(struct phase *f);

/* The effect `kink` comes to its other side, at the present state; what effects hold from then on is set. */
enum outcome change_side(struct phase *f, int kink);

/* Where a run goes on without looking for kinks: the sides of the present state, and what effects hold that have come to theirs */
enum outcome follow_sides(struct phase *f);

/* A run begins: effects are on no side yet and hold nothing. */
void forget_latches(struct phase *f);

/* A run begins where another has ended: effects hold latched[latches], and are on the sides from which the motion comes. */
enum outcome keep_latches(struct phase *f, const double *latched);

#endif
