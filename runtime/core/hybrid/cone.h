/* Velocities with which a motion can leave a place where closure rows are dependent; see cone.c. */
#ifndef CCGEN_CONE_H
#define CCGEN_CONE_H

#include "steps/step.h"

/* After an impact where a row of the closure is lost, bring the velocities to the nearest ones along which the loop can go on, and no closed contact is driven
 * into its ground: of the nearest for each set of contacts that stay at rest, the nearest that drives none in. Nothing is done with more than eight closed contacts, where
 * two rows are lost, or where none is found. What it takes is recorded as an impact without impulses: it is the loop that strikes itself. */
enum outcome leave_on_cone(struct phase *f);

#endif
