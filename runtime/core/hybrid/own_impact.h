/* Impacts of loops with themselves; see own_impact.c. */
#ifndef CCGEN_OWN_IMPACT_H
#define CCGEN_OWN_IMPACT_H

#include "steps/step.h"

/* Record that the closure has taken `loss` (J) from the state before[size], at this instant: an impact without impulses of the contacts that are closed there. */
enum outcome note_own_impact(struct phase *f, double *before, double loss);

/* Put what has come beside a place onto its branch, and record what that takes if it is more than a step may miss. */
enum outcome come_onto_branch(struct phase *f);

#endif
