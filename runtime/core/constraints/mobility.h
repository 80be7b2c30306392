/* Contacts whose gaps no motion can change. */
#ifndef CCGEN_MOBILITY_H
#define CCGEN_MOBILITY_H

#include "model/system.h"

/* moves[count]: whether some motion that loops and driven joints leave changes the gap of each of the contacts `set`. One that none changes has a
 * row that depends on theirs, by the same measure as a row of the closure (RANK_TOLERANCE): no force between its bodies does anything. */
enum outcome movable_contacts(struct system *s, const double *q, int count, const int *set, char *moves);

/* The rows row[rows], of gaps and then of sliding, that hang together with the row `first`, of those that hold and are not taken yet: each moves another by the rates W[rows][rows]
 * that impulses give, or is of one contact with it. What moves another by less than Coulomb's law may be missed by does not count. How many they are; they are taken then. */
int rows_that_move_each_other(int contacts, int rows, const char *holds, const double *W, int first, char *taken,
                              int *row);

/* Whether masses hide what contacts set[count] can do: rows of their gaps and sliding that are independent of each other, as motions are that loops and driven joints leave,
 * but not in the rates W[all][all] that impulses give them, of `delassus`, as far as the digits of these show. Then no impulses can be known. Only rows
 * that hold count, holds[all]: those of gaps that push, then of sliding that sticks; and of these only the blocks that move each other with one of the
 * contacts asked[count] about. The first contact of such a block, as a number in `set`; -1 where there is none, or that cannot be found. */
int masses_hide(struct system *s, const double *q, int count, const int *set, const char *holds, const char *asked,
                const double *W);

#endif
