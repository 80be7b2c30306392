/* Inputs of the model over time; see inputs.c. */
#ifndef CCGEN_INPUTS_H
#define CCGEN_INPUTS_H

#include "model/system.h"

/* How many inputs the scene has itself: those that a supply gives */
int own_inputs(const struct ccgen_model *m);

/* On which sides of their kinks effects are at a state, and what they hold if that is where it is set, behind the scene's own inputs[inputs] */
void find_sides(const struct ccgen_model *m, const double *k, double t, const double *q, const double *u,
                double *inputs);

/* The inputs of the system at a state, if something supplies them, and the sides of effects and what they hold; OUTCOME_INTERRUPTED
 * where the supply ends the run. */
enum outcome supply_inputs(struct system *s, double t, const double *q, const double *u);

/* Values over time, interpolated linearly, constant before the first row and after the last */
struct input_table {
    size_t count;
    int width;
    const double *t;      /* [count] times that grow */
    const double *values; /* [count][width] */
    size_t row;           /* where it was last looked at */
};
int input_from_table(void *table, double t, const double *q, const double *u, double *inputs);

#endif
