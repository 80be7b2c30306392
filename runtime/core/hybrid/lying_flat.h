/* Loops that come to lie in a line on their ground, nearer to it than places are known; see lying_flat.c. */
#ifndef CCGEN_LYING_FLAT_H
#define CCGEN_LYING_FLAT_H

#include "steps/step.h"

/* Put a loop that all but lies on its ground in a line down there, and have all contacts of it strike once more, without restitution. *contact is one of
 * them, or -1: nothing is done where there is no such loop, one of them has the restitution 1, or that would take more of the energy that has been in
 * motion than the root of rounding. */
enum outcome lay_flat(struct phase *f, int *contact);

#endif
