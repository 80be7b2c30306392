/* Search through a step for the first instant at which a held contact is not held any more. */
#ifndef CCGEN_LOSS_SEARCH_H
#define CCGEN_LOSS_SEARCH_H

#include "steps/step_search.h"

/* First event of the watched values of held contacts. They are looked at in windows that are halved until the samples in them
 * show what is between: a body at rest takes long steps whatever its loads do meanwhile. */
struct event first_loss(struct search *search);

#endif
