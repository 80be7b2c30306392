/* Impacts without collision; see jam.c. */
#ifndef CCGEN_JAM_H
#define CCGEN_JAM_H

#include "steps/step.h"

/* Resolve the impact without collision of the contacts that are closed and at rest along their normals: *contact is the first of them, or -1 where there is none. It
 * is recorded as an impact. */
enum outcome strike_without_collision(struct phase *f, int *contact);

#endif
