/* What joints do to the second of their two links.
 *
 * A model's functions give the force of a joint as its equations have it, on the outboard link of the virtual open chain. Which of
 * the two links that is, the cuts and the root decide. What is reported is on the joint's second link, wherever it is cut. */
#ifndef CCGEN_SECOND_LINKS_H
#define CCGEN_SECOND_LINKS_H

#include "model/system.h"

/* Turns reaction[blocks][joints][3][lanes], of one of the model's functions of reactions (1 block, 1 lane) or of its tangents, from
 * the outboard links to the second ones. */
void turn_to_second_links(const struct ccgen_model *m, size_t blocks, size_t lanes, double *reaction);

#endif
