/* The branch of closed configurations on which a motion passes a place where closure rows are dependent; see branch.c. */
#ifndef CCGEN_BRANCH_H
#define CCGEN_BRANCH_H

#include "constraints/chart.h"

/* Room for a branch of a model; 0, or 1 when memory runs out */
int take_branch(struct arena *arena, const struct ccgen_model *m, struct branch *b);

/* Whether velocities u[n] are more than those of what is at rest */
int moves(const struct system *s, const double *u);

/* Have the chart begin at a state with these velocities; where it stands, the velocities that told a branch last are used instead. NOT_CLOSED where rows are
 * dependent there, and velocities do not say which branch it is; NO_BRANCH where they are those of none. */
enum outcome begin_branch(struct system *s, struct branch *b, const double *q, const double *given);

/* What is asked for next lies near the beginning of the chart again. */
void rewind_branch(struct branch *b);

/* The last configuration is that at y[freedom]. NOT_CLOSED where no branch passes there. */
enum outcome lift_branch(struct system *s, struct branch *b, const double *y);

/* Whether the system follows a branch at q[n]: not so far from the place that the closure as it is tells all */
int follows_at(struct system *s, const double *q);

/* Whether the system follows a branch that passes by a place, where rows tell all that they tell elsewhere */
int passes_by(const struct system *s);

/* Whether the system follows a branch through a place where it crosses another */
int goes_through_crossing(const struct system *s);

/* How near to dependence rows are where the chart begins or at the last configuration, where the system passes a place by; 1 else: what rounding is to be divided by */
double nearest_margin(const struct system *s);

/* The time after which a motion that begins with velocities u[n] where the chart does comes nearest to the place that it passes by; 0 where that is not known, or behind */
double time_to_place(const struct system *s, const double *u);

/* Whether the state is the one that was put onto the system's branch last, or a configuration its configuration */
int is_on_branch(const struct system *s, const double *q, const double *u);
int is_place_on_branch(const struct system *s, const double *q);

/* q[n] and u[n] <- the state that was put onto the system's branch last */
void read_state_on_branch(const struct system *s, double *q, double *u);

/* T[freedom][n], tangents of the branch there, in units of the coordinates */
const double *branch_tangents(const struct branch *b);

/* a[n]: accelerations of the state that was put onto the branch last, with rates in the chart that stay as they are */
enum outcome branch_bias(struct system *s, double *a);

#endif
