/* Derivatives of the accelerations of a motion with contacts held; see held_tangents.c. */
#ifndef CCGEN_HELD_TANGENTS_H
#define CCGEN_HELD_TANGENTS_H

#include "interface/forces.h"
#include "motion/tangent.h"

/* A state with what belongs to it: accelerations u_dot[n], multipliers[rows] and forces of contacts push[2 contacts], as
 * held_forces tells them */
struct pushed {
    double t;
    const double *q, *u, *u_dot, *multipliers, *push;
};

/* The directions, as blocks of those that accelerations move along, and as whole blocks of what functions of contacts read: of all
 * arguments, and but for u. */
struct whole_directions {
    const struct directions *along;
    struct ccgen_arguments all, still;
};

/* tangents[blocks][n + rows][lanes], of which the first n are those of the accelerations. *sure is 0, and they are not to be used,
 * where rows of closure or of contacts may depend on each other, or friction that slides is not at its limit. */
enum outcome held_tangents(struct system *s, const struct pushed *at, struct held held,
                           const struct whole_directions *by, double *tangents, int *sure);

#endif
