/* What events and joints have changed along a run; see changes.c. */
#ifndef CCGEN_CHANGES_H
#define CCGEN_CHANGES_H

#include "interface/simulation.h"

/* A change that is tried, with the parameters that are set then; NULL when memory runs out. It stays where it is until the next. */
struct ccgen_change *try_change(struct ccgen_simulation *it, int indicator, int gate);

/* Those of the instant are done, and motion has begun anew behind them; `at` is how much was recorded before. Where one of them cannot be, all stay as tried, for who says why. */
void keep_changes(struct ccgen_simulation *it, struct recorded at);

/* Forget those from a row on. */
void cut_changes(struct ccgen_simulation *it, size_t row);

void forget_changes(struct ccgen_simulation *it);
void free_changes(struct ccgen_simulation *it);

#endif
