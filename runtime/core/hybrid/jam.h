/* Impacts without collision; see jam.c. */
#ifndef CCGEN_JAM_H
#define CCGEN_JAM_H

#include "steps/step.h"

/* Resolve the impact without collision of the contacts that are closed and at rest along their normals: whether there is one is in *done. It
 * is recorded as an impact. */
enum outcome strike_without_collision(struct phase *f, int *done);

#endif
