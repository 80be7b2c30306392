/* How contacts are held that have been selected; see activation.c. */
#ifndef CCGEN_ACTIVATION_H
#define CCGEN_ACTIVATION_H

#include "hybrid/decision.h"

/* Acceleration of row i of a decision, a gap, or beyond `count` a sliding, with the forces P[all] */
double gap_acceleration(const struct decision *d, int i, const double *P);

/* Whether contact i has a force that presses, and whether it is held */
int pushes(const struct decision *d, int i);
int stays(const struct decision *d, int i);

/* Hold the contacts that stay, and note which others they carry. Forces of least norm share the
 * friction of those that stick, beside each other or with the joints; if that is more than one of them can bear, they share
 * it as the solution has it. */
enum outcome activate_selected(struct phase *f, struct decision *d, struct mode_change loss);

#endif
