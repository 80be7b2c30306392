/* Power that changes the energy. */
#ifndef CCGEN_POWER_H
#define CCGEN_POWER_H

#include "constraints/active_set.h"

/* power[1] of the effects that have no potential and of friction in contacts, for a system with an entry of work; what
 * driven joints take and how hard contacts push depends on the accelerations, which are solved for then */
enum outcome system_power(struct system *s, double t, const double *q, const double *u, double *power);

/* The same with the u_dot[n], lambda[rows] and forces of the state, where they are known */
enum outcome power_with(struct system *s, double t, const double *q, const double *u, const double *u_dot,
                        const double *lambda, double *power);

#endif
