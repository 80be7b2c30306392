/* On which sides of their kinks effects are: their switching functions (docs/theory, eq. 5.18). */
#ifndef CCGEN_SIDES_H
#define CCGEN_SIDES_H

#include "model/system.h"

/* Switching functions of the effects at (t, y), value[switches], each with the sign that makes it positive on the side on which the
 * effect is held: 0, or OUTCOME_INTERRUPTED where the supply of the inputs ends the run */
enum outcome side_functions(struct system *s, double t, const double *y, const double *sides, double *value);

/* What switching functions are known to at (t, y), noise[switches]: by how much they change where the state does by its rounding,
 * and as much of what they do where it changes by half a unit, since their terms have a rounding also where they are stationary, as the
 * distance of two points on a straight chain; moved[size], value[switches] and there[switches] are scratch. */
enum outcome side_noise(struct system *s, double t, const double *y, double *moved, double *value, double *there,
                        double *noise);

/* sides[switches] on which the motion from (t, y) on is, or where `direction` is -1 and not 1, the motion that leads there; of a function that is
 * all but zero there, the side to which it goes. The system holds none meanwhile; dy[size] and ahead[size] are scratch. */
enum outcome choose_sides(struct system *s, double t, const double *y, double *dy, double *ahead, int direction,
                          double *sides);

#endif
