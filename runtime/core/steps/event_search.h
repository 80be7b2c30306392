/* Search for the first instant in a step at which a point begins to enter a ground, or a held contact would pull. */
#ifndef CCGEN_EVENT_SEARCH_H
#define CCGEN_EVENT_SEARCH_H

#include "methods/method.h"
#include "steps/event.h"

/* *event: the first within the step from t to t + h that `method` has prepared. Either the gap of some contact is not positive
 * and falling. That is one-sided: a gap that is closed but opening is no event, and a gap that dips below zero and returns
 * within the step is one. A contact that is closed at the start of the step falls only if its rate is below -slow times
 * its extent, or if it never opens. Held contacts do not fall; with them an event is that a watched value becomes negative, of contacts that come to
 * bear in place of others only where `bears` is set. */
enum outcome find_event(struct system *s, const struct method *method, const double *steps, double t, double h,
                        double slow, int bears, struct event *event);

/* *event: the first instant at which an effect comes to the other side of its kink: its number is event->watch, there is no contact; the
 * number is -1 where there is none. */
enum outcome find_kink(struct system *s, const struct method *method, const double *steps, double t, double h,
                       struct event *event);

/* Whether a value that is zero at a start is negative all the way from there to where it is `value`, as it is `at_twice` twice as far away */
int falls_from_zero(double value, double at_twice);

#endif
