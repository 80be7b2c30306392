/* Contacts that touch alike and part; see twins.c. */
#ifndef CCGEN_TWINS_H
#define CCGEN_TWINS_H

#include "model/system.h"

/* Whether contacts a and b, which are closed at q, have the same row, rub alike, and part as something moves: 1 where the gap of a is the larger beside this place, so that
 * b bears, -1 where it is that of b, 0 where they are no twins, or memory has run out */
int twins_at(struct system *s, const double *q, int a, int b);

/* How far a coordinate is, in its unit, from where their rows are one: positive where the gap of a is the larger, negative where it is that of b. *aside
 * is 0 where they do not part. */
enum outcome twins_apart(struct system *s, const double *q, int a, int b, double *aside);

#endif
