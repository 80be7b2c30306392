/* Whether a run is to end; see interruption.c. */
#ifndef CCGEN_INTERRUPTION_H
#define CCGEN_INTERRUPTION_H

#include "base/real.h"

/* What a run asks the outside now and then. */
struct interruption {
    int (*tick)(void *context, double t); /* a nonzero answer ends the run; may be NULL */
    void *context;
    int at_once;   /* whether to ask costs less than to look at the clock, so that it is done at each look */
    double t;      /* how far the run is (s) */
    int64_t asked; /* when it was asked last (ns), unless it is asked at each look */
    long work;     /* done since the last look at the clock */
    int ended;     /* whether the answer was that the run is to end: it stays that */
};

/* From `t` on, where nothing has been asked. */
void start_asking(struct interruption *interruption, double t);

/* Ask at once; whether the run is to end. */
int ask(struct interruption *interruption);

/* Whether the run is to end; asked every hundredth of a second or two of computing, if this is called with the number of
 * freedoms wherever accelerations are worked out, and with 0 where more is done than that. Without an `interruption`, never. */
int interrupted(struct interruption *interruption, long work);

#endif
