/* Simultaneous impacts; see impact.c. */
#ifndef CCGEN_IMPACT_H
#define CCGEN_IMPACT_H

#include "model/system.h"

/* u_plus[n], P[2 count], normal impulses and then those of friction, for the contacts `set` struck together with
 * restitution e[count] by the system's law */
enum outcome impact(struct system *s, const double *q, const double *u_minus, int count, const int *set,
                    const double *e, double *u_plus, double *P);

/* Energy (J) that the contacts set[count] take by their impulses P[2 count] at q, where the rates of their gaps are before[contacts] and velocities
 * u_minus become u_plus; scratch[contacts] */
double contacts_take(const struct system *s, const double *q, int count, const int *set, const double *P,
                     const double *before, const double *u_minus, const double *u_plus, double *scratch);

/* Energy (J) that goes where velocities u_minus become u_plus at q, whatever does it; du[n] = u_plus - u_minus, momentum[n] is scratch */
double jump_loss(const struct system *s, const double *q, const double *u_minus, const double *u_plus, double *du,
                 double *momentum);

#endif
