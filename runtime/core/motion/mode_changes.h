/* When held contacts end being held as they are: the switching functions. */
#ifndef CCGEN_MODE_CHANGES_H
#define CCGEN_MODE_CHANGES_H

#include "constraints/active_set.h"

/* how a held contact ends being held as it is; STIRS: what touched without pressing presses or pulls */
enum { PULLS, STOPS, GIVES_FORWARD, GIVES_BACKWARD, STIRS };

struct loss {
    int contact, how;
};

/* What must stay positive for the held contacts to stay as they are, values[watched], and what number `index` is about.
 * dy[size] is the derivative at (t, y). */
int watched(const struct system *s);
struct loss watcher(const struct system *s, int index);
enum outcome watch(struct system *s, double t, const double *y, double *dy, double *values);

#endif
