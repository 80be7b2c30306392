/* Gaps of contacts, all of them lengths.
 *
 * The gap of a stop of an angle is an angle, its impulse one of a couple. Beside grounds their rows are compared: rates with rates,
 * accelerations with accelerations, pivots with pivots. So the core takes every gap as a length: that of an angle times its
 * lever, and what pushes there as a force at that lever. Levers are powers of two, so that nothing is rounded. What is recorded, and
 * what leaves the core, is in the units of the gap again. */
#ifndef CCGEN_CONTACTS_H
#define CCGEN_CONTACTS_H

#include "model/system.h"

/* Set the levers of the contacts, lever[contacts], and the scales of their gaps, extent[contacts], from the mechanism's length;
 * angular[contacts] tells which gaps are angles, NULL that none is. Both arrays stay with the system. */
void set_levers(struct system *s, const unsigned char *angular, double *lever, double *extent);

/* Metres per unit of the gap of a contact: 1, or of an angle the mechanism's length but for a factor of less than two */
static inline double lever_of(const struct system *s, int contact)
{
    return s->lever ? s->lever[contact] : 1.0;
}

/* gaps[contacts] (m) at q */
void contact_gaps(const struct system *s, const double *q, double *gaps);

/* and their rates (m/s) of velocities u; or N u_dot, of accelerations */
void contact_rates(const struct system *s, const double *q, const double *u, double *rates);

/* and what accelerates them besides: dN/dt u (m/s^2) */
void contact_bias(const struct system *s, const double *q, const double *u, double *bias);

#endif
