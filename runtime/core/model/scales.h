/* The scales of a mechanism: what is small and what counts as an instant is told by its own length, time and energy. */
#ifndef CCGEN_SCALES_H
#define CCGEN_SCALES_H

#include "model/system.h"

/* Set the units of all entries of a state from length, time and energy. */
void set_units(struct system *s);

/* Kinetic energy (J) of the coordinate that has the most at a speed of its unit, all others at rest; -1 when memory runs out */
double heaviest(struct system *s, const double *q);

/* Set the characteristic time and energy of a motion that begins at configuration q, and the units: its time is `longest` (s), or
 * half a turn at the rate (1/s) at which it begins, where that is less. Its energy is what one coordinate, the one
 * that has most, has at a speed of its unit. */
enum outcome set_scales(struct system *s, double longest, double rate, const double *q);

/* Whether an angle of the configuration q has a last digit larger than ANGLE_KNOWN: full turns have used up the others. */
int turned_far(const struct system *s, const double *q);

#endif
