/* Search for the first instant in a step at which a point begins to enter a ground. */
#ifndef CCGEN_EVENTS_H
#define CCGEN_EVENTS_H

#include "method.h"

struct event {
    int contact; /* -1: none */
    double theta; /* part of the step */
};

/* First event within the step that `method` has prepared: the gap of some contact is not positive and falling. Events are
 * one-sided: a gap that is closed but opening is none, and a gap that dips below zero and returns within the step is one.
 * A contact that is closed at the start of the step falls only if its rate is below -slow (m/s), or if it never opens.
 * `scratch` has size + 5 contacts numbers. */
struct event find_event(struct system *s, const struct method *method, const double *steps, double slow,
                        double *scratch);

#endif
