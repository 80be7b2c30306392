/* The hybrid automaton: smooth phases and impacts in turn. */
#ifndef CCGEN_AUTOMATON_H
#define CCGEN_AUTOMATON_H

#include "steps/step.h"

/* The hybrid automaton. Motion is smooth, with some contacts held or with none (flight), until an event; then closed
 * contacts that approach strike, and those that are pressed shut and do not bounce are held from then on. */
enum outcome run_automaton(struct phase *f);

#endif
