/* Coulomb friction at contacts in the plane as one complementarity problem; see friction.c. */
#ifndef CCGEN_FRICTION_H
#define CCGEN_FRICTION_H

#include "complementarity/coulomb.h"

/* The n contacts of the problem. W[2n][2n] are the rates of normals, then of tangents, that unit impulses along them give; bn[n], bt[n] the
 * rates (or accelerations) without impulses, mu[n] the coefficients. mode[n] is 1 or -1 where a contact slides forward or
 * backward, 0 where that is to be found. Impulses Pn[n] >= 0, Pt[n], both beyond least[n] >= 0 of the normal ones where
 * that is given. The problem is prepared (coulomb.h). Returns 0; 1 where there is no solution; 2 when memory or pivots run out. */
int solve_friction(const struct friction_problem *c, double *Pn, double *Pt);

/* The same in an impact, to the last digits. Where contacts can wedge a mechanism that has come to rest, any impulses large enough
 * would do: those that stop it are the least. Where they are large, the least of all motions are taken that meet the law. */
int solve_friction_least(const struct friction_problem *c, double *Pn, double *Pt);

#endif
