/* Linear complementarity by pivoting; see lemke.c. */
#ifndef CCGEN_LEMKE_H
#define CCGEN_LEMKE_H

#include "base/arena.h"

/* 0 <= z, 0 <= w = M z + q, z.w = 0 for M[m][m]. cover[m] > 0 is what is added to q, to be taken away again (all 1 where NULL);
 * the pivots are those of q + shift where shift[m] >= 0 is given. in[m] says which z are in the last basis. Returns 0; 1 where
 * pivoting ends on a ray; 2 when memory or pivots run out. */
int lemke(struct arena *arena, int m, const double *M, const double *q, const double *cover, const double *shift,
          double *z, char *in);

#endif
