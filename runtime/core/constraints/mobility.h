/* Contacts whose gaps no motion can change. */
#ifndef CCGEN_MOBILITY_H
#define CCGEN_MOBILITY_H

#include "model/system.h"

/* moves[count]: whether some motion that loops and driven joints leave changes the gap of each of the contacts `set`. One that none changes has a
 * row that depends on theirs, by the same measure as a row of the closure (RANK_TOLERANCE): no force between its bodies does anything. */
enum outcome movable_contacts(struct system *s, const double *q, int count, const int *set, char *moves);

#endif
