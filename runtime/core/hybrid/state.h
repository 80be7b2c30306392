/* What a run is a function of: with the same state, model and settings it goes on by the same bits. */
#ifndef CCGEN_STATE_H
#define CCGEN_STATE_H

#include "hybrid/automaton.h"

/* Bytes of a state: time, coordinates and velocities, the active set, the stage of the automaton, and all that it, the steps and the
 * method remember. As numbers lie in memory: for the same kind of processor, and the same model, method and precision. */
size_t state_size(const struct phase *f);

/* Copy the state out. */
void get_state(const struct automaton *a, const struct phase *f, void *bytes);

/* The same within a simulation, without what says which model, method and precision it is of: its bytes, a copy, and back to it. */
size_t kept_size(const struct phase *f);
void keep_state(const struct automaton *a, const struct phase *f, void *bytes);
void take_back(struct automaton *a, struct phase *f, const void *bytes);

/* Put a sum into a state, by which damage shows. */
void seal_state(void *bytes, size_t size);

/* Whether it is as it was sealed */
int is_whole(const void *bytes, size_t size);

/* Go on from it; 0, or 1 where it is of another model, method or precision: nothing is changed then; or 2 where its numbers are
 * damaged: another has to be set then. The model's equations count, not the values of its parameters. */
int set_state(struct automaton *a, struct phase *f, const void *bytes);

#endif
