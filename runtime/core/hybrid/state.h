/* What a run is a function of: with the same state, model and settings it goes on by the same bits. */
#ifndef CCGEN_STATE_H
#define CCGEN_STATE_H

#include "hybrid/automaton.h"

/* Bytes of a state: time, coordinates and velocities, the active set, the stage of the automaton, and all that it, the steps and the
 * method remember. As numbers lie in memory: for the same kind of processor, and the same model, method and precision. */
size_t state_size(const struct phase *f);

/* Copy the state out. */
void get_state(const struct automaton *a, const struct phase *f, void *bytes);

/* Go on from it; 0, or 1 where it is of another model, method or precision: nothing is changed then. The model's equations count,
 * not the values of its parameters. */
int set_state(struct automaton *a, struct phase *f, const void *bytes);

#endif
