/* Where in steps events of the scene may be; see scene_events.c. */
#ifndef CCGEN_SCENE_EVENTS_H
#define CCGEN_SCENE_EVENTS_H

#include "steps/step.h"

enum {
    EVENT_PARTS = 8, /* of a step, between two looks at event indicators: the bits of a byte */
    INDICATOR_ROUNDINGS =
        64 /* what is nearer to zero than so many roundings of an indicator is zero: its size is a bound to first order, with some tens of terms in a kernel */
};

/* The eighths of the step to y1 in which an event indicator may come to zero, as bits, the first the lowest. The derivative at its end is known, for methods that want it, and the dense
 * output prepared in models with contacts. */
unsigned char where_events_may_be(struct phase *f);

#endif
