/* Contacts that loops and driven joints leave no motion: impulses there do nothing, and have no solution. */
#ifndef CCGEN_IMMOVABLE_H
#define CCGEN_IMMOVABLE_H

#include "steps/step.h"

/* Leave out of the contacts set[*count], closed at q and with the rates f->rates, those whose gaps no motion changes and that approach by rounding; one that is driven into its ground
 * stays. A model without drives has none. */
enum outcome leave_out_immovable(struct phase *f, const double *q, int *count, int *set);

#endif
