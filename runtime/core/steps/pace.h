/* Whether a run gets on: what its steps and events may spend, and what steps do that move nothing. */
#ifndef CCGEN_PACE_H
#define CCGEN_PACE_H

#include "steps/step.h"

/* The time (s) in which a run may spend its budget of steps and events: a characteristic time; a tenth of the duration where that is less, a
 * ten-thousandth where that is more, for a run that would take forever is to end */
double window_of(const struct phase *f);

/* Whether a twentieth of the steps that a window may have, in a row, have each moved less than is known where links lie in a line */
int is_crawling(const struct phase *f);

/* Steps that turn links get the motion on, however short they are against the characteristic time: what has led to the one that is to be committed,
 * since the run had taken and refused `spent`, is not counted among those that a window may have. */
void excuse_progress(struct phase *f, long spent);

/* Whether links have gone no further in the step than their places are known to where they lie in a line, by themselves or with grounds. Without contacts
 * that counts where a loop is near a line, of steps that did not have to end there. */
int stalls(const struct phase *f);

/* Whether steps crawl and have taken next to no time, so that none will get on; without contacts they would at last be on another branch. Prescribed
 * motions between contacts and steps of fixed length have no other way on: they keep the whole budget of a window. */
int is_stuck(const struct phase *f);

/* Whether the run may take another step */
enum outcome within_budget(struct phase *f);

#endif
