/* Time stepping: the last resort where event by event does not get further; see time_stepping.c. */
#ifndef CCGEN_TIME_STEPPING_H
#define CCGEN_TIME_STEPPING_H

#include "steps/step.h"

/* A span of time stepping */
struct span {
    double length; /* s; 0 before the first */
    double begins; /* when the present or the last one did */
    double ends;   /* and when it does, */
    double step;   /* and the step that it tries next */
    double scale;  /* J: of the heaviest coordinate at a speed of its unit, where it began; 0: not known yet */
    int under_way;
};

/* Whether a step has failed as contacts have no impulses, or no place, that it finds */
int contacts_have_none(enum outcome outcome);

/* Begin a span at the present state: all contacts are apart until it ends. One that begins soon after another ended is longer. */
enum outcome begin_span(struct span *span, struct phase *f);

/* Go on to the end of the span, or of the run. */
enum outcome step_through_span(struct span *span, struct phase *f);

/* Go on to the end of the run by steps of the run's own fixed length. */
enum outcome step_to_end(struct span *span, struct phase *f);

#endif
