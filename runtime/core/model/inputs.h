/* Inputs of the model over time; see inputs.c. */
#ifndef CCGEN_INPUTS_H
#define CCGEN_INPUTS_H

#include "model/system.h"

/* The inputs of the system at a state, if something supplies them; OUTCOME_INTERRUPTED where that ends the run. */
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
