/* Step control: steps as long as the tolerance allows. */
#ifndef CCGEN_STEP_CONTROL_H
#define CCGEN_STEP_CONTROL_H

#include "steps/step.h"

/* Step until the error test passes; the step's length is in f->h before and after, `next` is the one to try then. */
enum outcome accepted_step(struct phase *f, double *next);

/* First step size by comparing an Euler step with its derivative (Hairer, Norsett, Wanner 1993, section II.4). */
double first_step(struct phase *f);

/* Whether the step has gone further than its velocities carry it: where the loops are all but flat, stages and projection may
 * find another way to close them, which the error across the closure, left out above, does not tell. */
int outruns_velocity(const struct phase *f);

/* The shortest step that moves time */
double shortest(const struct phase *f);

/* y1 at the time `until`, without events or a record: by as many steps as the tolerance asks for, or by one whatever its error, back in time, where no tolerance is
 * given or the method estimates nothing, and where contacts or kinks may have ended a step */
enum outcome advance_to(struct phase *f, double until);

/* The least factor by which a refused step is shortened at once */
extern const double LEAST_CHANGE;

#endif
