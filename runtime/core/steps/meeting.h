/* Where the ends of a line meet that loads have the direction of, as of a spring with a length at rest (docs/theory, section 5.12). */
#ifndef CCGEN_MEETING_H
#define CCGEN_MEETING_H

#include "steps/step.h"

/* Whether the step just taken is refused since it passes where the ends of a line meet or all but meet: f->at.meets is then the longest to try
 * next, else 0. There a load turns within less than what separates the stages of a step, and none of them need see it. */
enum outcome refuse_before_meeting(struct phase *f, int *refused);

#endif
