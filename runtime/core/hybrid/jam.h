/* Impacts without collision; see jam.c. */
#ifndef CCGEN_JAM_H
#define CCGEN_JAM_H

#include "steps/step.h"

/* Resolve the impact without collision of the contacts that are closed and at rest along their normals: *contact is the first of them, or -1 where there is none. It
 * is recorded as an impact. */
enum outcome strike_without_collision(struct phase *f, int *contact);

/* The held contact that slides and is nearest to jamming, whose force grows without bound as what its friction resists with comes to what it is resisted by: *contact,
 * or -1 where none is near. */
enum outcome find_jamming(struct phase *f, int *contact);

#endif
