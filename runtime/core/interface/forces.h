/* What contacts do to a motion: the accelerations with them, the multipliers, and how hard they push and rub. */
#ifndef CCGEN_FORCES_H
#define CCGEN_FORCES_H

#include "model/system.h"

/* Contacts `set` that are held, `mode` as in constraints/active_set.h; what others carry has no force. With a negative count, those that the runtime would hold at the state. Where they are
 * `shared`, forces that this leaves open are those of least norm within Coulomb's limits, of those too that are carried, or whose friction is said to be at its limit. */
struct held {
    int count;
    const int *set;
    const signed char *mode;
    int shared;
};

/* Why a state has no such forces, besides outcomes: a contact strikes, or lies behind its surface. */
#define ALL_OBSTACLES(X)  \
    X(NONE, "")           \
    X(STRIKES, "strikes") \
    X(BEHIND, "behind")

#define ENTRY(name, text) OBSTACLE_##name,
enum obstacle { ALL_OBSTACLES(ENTRY) OBSTACLES };
#undef ENTRY

/* the name of one */
const char *obstacle_name(int obstacle);

struct obstruction {
    size_t state;
    int contact;
    enum obstacle why;
    double size; /* m/s or rad/s, or m or rad */
};

/* Of `count` states, at t[i * every] (every is 0 or 1), q[count][n], u[count][n]: u_dot[count][n], lambda[count][rows + 1],
 * push[count][2 contacts], normal forces (N, N m) and then those of friction, zero of contacts that are not held, and
 * reaction[count][joints][3] with them, on the joints' second links. They belong together; where they are not unique they are
 * those of least norm. What effects tell at each state: told[count][told]. Stops at the first state that has none, which `found` then tells. latched[count][latches] is what effects hold at each state, or NULL where
 * no run has set it.
 *
 * Where closure rows are dependent, or nearly so, all are the limits along the branch of the motion, infinite where a joint has none (limits.h). Where there is no
 * such branch, unknown[count] tells whether rows are too near to dependence for any acceleration to be known. With NULL in its place there are no limits: the equations as they are. */
enum outcome held_forces(struct system *s, size_t count, size_t every, const double *t, const double *q,
                         const double *u, const double *latched, struct held held, double *u_dot, double *lambda,
                         double *push, double *reaction, double *told, char *unknown, struct obstruction *found);

/* Of an impact at q with the jumps du[n] and impulses P[2 contacts]: reaction[joints][3] (N s, N m s) on the second links */
enum outcome joint_impulses(struct system *s, const double *q, const double *du, const double *P, double *reaction);

/* closed[count][contacts]: which contacts are closed at q[count][n], their gaps being zero but for rounding */
enum outcome find_closed(const struct system *s, size_t count, const double *q, char *closed);

#endif
