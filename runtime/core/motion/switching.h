/* When held contacts end being held as they are: the switching functions. */
#ifndef CCGEN_SWITCHING_H
#define CCGEN_SWITCHING_H

#include "constraints/active_set.h"

/* how a held contact ends being held as it is; LOADS: what touched without pressing presses or pulls. BEARS: one that is carried gets behind its surface
 * where the one that bears in its place goes on to */
enum { DETACHES, SLIP_ENDS, SLIPS_FORWARD, SLIPS_BACKWARD, LOADS, BEARS };

struct mode_change {
    int contact, how;
};

/* What must stay positive for the held contacts to stay as they are, values[watched], and what number `index` is about.
 * dy[size] is the derivative at (t, y). */
int switching_count(const struct system *s);
struct mode_change mode_change_of(const struct system *s, int index);
/* N: what forces are known to where the motion passes a place by (docs/theory, eq. 8.12), 0 elsewhere */
double missed_force(const struct system *s, const double *y);

enum outcome switching_functions(struct system *s, double t, const double *y, double *dy, double *values);

#endif
