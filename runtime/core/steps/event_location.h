/* Landing on events: the step that found one is taken again so that it ends there. */
#ifndef CCGEN_EVENT_LOCATION_H
#define CCGEN_EVENT_LOCATION_H

#include "steps/step.h"

/* Step from (t, y) to y1 at the event, of length f->h, as accurate as any step's end; 0 where the event is at t. */
enum outcome locate_event(struct phase *f, struct event event);

/* The same, of an effect that comes to the other side of its kink */
enum outcome locate_kink(struct phase *f, struct event event);

#endif
