/* A run: flight and impact in turn, from a start to an end, everything recorded. */
#ifndef CCGEN_SIMULATE_H
#define CCGEN_SIMULATE_H

#include "record/run.h"

/* Simulate from y[2 n] = [q; u], which is projected onto the closure first. Whatever the outcome, the record holds all that
 * was reached; free it with free_run. */
void simulate(struct system *s, struct run *run, double *y);

/* From y at t on by h, with the contacts `set` held, `mode` as in constraints/active_set.h, projected as `drift` says: for states between
 * two rows of a record. One step of the method, or in a model without contacts as many as the tolerance, unless it is zero,
 * asks for. */
enum outcome advance(struct system *s, const struct method *method, struct tolerance tolerance, enum drift drift,
                     double t, double h, int count, const int *set, const signed char *mode, double *y);

#endif
