/* Impacts of the contacts that are closed and not opening. */
#ifndef CCGEN_STRIKING_H
#define CCGEN_STRIKING_H

#include "steps/step.h"

/* All impacts of one instant: those contacts that are closed and not opening are struck together; if a closed contact is
 * left approaching, another impact follows. `trigger` is the contact whose event led here, or -1. */
enum outcome resolve_impacts(struct phase *f, int trigger);

#endif
