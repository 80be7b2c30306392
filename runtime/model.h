/* The contract between a generated model and the runtime.
 *
 * A generated model fills one `struct ccgen_model` and hands its address over in a capsule named "ccgen.model". All arrays
 * are contiguous and in SI units; matrices are stored row by row. No function keeps state, allocates, or fails other than
 * by its return value, so all may be called from several threads at once.
 *
 * Sizes:   nq = nu     coordinates q and quasi-velocities u, u = dq/dt
 *          base        coordinates of the floating root's place, which come first; link angles and slides follow
 *          rows        closure rows, two per cut pin and one per cut joint that slides; while a parameter that gates a row
 *                      is not 1 the row is off: zero in all functions, and its multipliers are 0
 *          constants   numbers that the kernels read: derived from the parameters by `constants` once per parameter set
 *          contacts    (point, ground) pairs; where it is 0 the functions of contacts are NULL
 *
 * Functions that solve for accelerations or impulses return 0, or 1 where a pivot almost vanishes: the closure rows are, or
 * nearly are, dependent, or in a large mechanism two links that hang from others stand in line. Their results are then not to
 * be used. The runtime solves such a state on another way, from
 * closure_jacobian, closure_bias, momentum and inverse_dynamics.
 */
#ifndef CCGEN_MODEL_H
#define CCGEN_MODEL_H

#define CCGEN_CONTRACT_VERSION 19

/* What a model's C gives to others ends in its package's name, so that a program can hold many models. An extension module
 * holds one: with CCGEN_BOUND it is called the same in all, and is told its name and its hash when it is linked, so that
 * models which differ in nothing else share what is compiled. */
#ifdef CCGEN_BOUND
#define CCGEN_CALLED(what, package) what##_bound
#define CCGEN_SAID(what, text) ccgen_bound_##what
extern const char ccgen_bound_name[], ccgen_bound_hash[];
#else
#define CCGEN_CALLED(what, package) what##_##package
#define CCGEN_SAID(what, text) text
#endif

/* 1 where x is positive, else 0: formulas with branches */
static inline double unit_step(double x)
{
    return x > 0 ? 1 : 0;
}

/* k[constants] from parameters p[parameters] */
typedef void ccgen_constants(const double *p, double *k);

/* u_dot[nu], lambda[rows] (N, force on the second side of each cut) from q[nq], u[nu], time t (s), inputs[inputs]. Where lambda
 * is NULL, multipliers that nothing else needs are not computed; so it is with Lambda of `impulse`. */
typedef int ccgen_acceleration(const double *k, const double *q, const double *u, double t, const double *inputs,
                               double *u_dot, double *lambda);

/* The same for `lanes` states side by side: value i of lane l of q, u, t, inputs, u_dot and lambda at [i * lanes + l]. Returns
 * the lanes in which a pivot almost vanishes as bits, lane l as bit l: their results are not to be used. */
typedef unsigned ccgen_acceleration_lanes(const double *k, const double *q, const double *u, const double *t,
                                          const double *inputs, double *u_dot, double *lambda);

/* The same for `lanes` states that lie one after the other: q[lanes][nq], u[lanes][nu], u_dot[lanes][nu] and
 * lambda[lanes][rows], at times t[lanes], all with the same inputs[inputs]; lambda may be NULL. It returns the bits of the
 * states that it has not solved, the first state's the lowest; states whose accelerations are not finite are among them. */
typedef unsigned ccgen_acceleration_states(const double *k, const double *q, const double *u, const double *t,
                                           const double *inputs, double *u_dot, double *lambda);

/* Sums over the stages of a method, for `lanes` of its stages side by side, `stages` even:
 * out[i * lanes + l] = base[i] + slope[i] node[l] + sum over j of x[i * stages + j] matrix[j * lanes + l], i < n */
typedef void ccgen_stages(int n, int stages, const double *base, const double *slope, const double *node,
                          const double *matrix, const double *x, double *out);

/* M du = A^T Lambda + f, A du = y:  du[nu], Lambda[rows] (N s) from q[nq], generalized impulses f[nu], rates y[rows] */
typedef int ccgen_impulse(const double *k, const double *q, const double *f, const double *y, double *du,
                          double *Lambda);

/* reaction[joints][3]: force x, y (N) and moment (N m) on the joint's outboard link, from q[nq], u[nu] and the u_dot[nu],
 * lambda[rows] that belong to them; the moment of a prismatic joint is about its point on the later one of its links, the ground
 * being before all. Times sides[joint] it is what the joint does to its second link, as the runtime reports it
 * (core/model/second_links.h): that of the next two functions too, and the tangents of all three. */
typedef void ccgen_reactions(const double *k, const double *q, const double *u, double t, const double *inputs,
                             const double *u_dot, const double *lambda, double *reaction);

/* reaction[joints][3] that forces P of the contacts add to the above, or impulses to those below, from q[nq] and P: normal
 * ones [contacts] (N, N m; N s, N m s), and behind them, where there is slip_impulse, tangential ones [contacts] */
typedef void ccgen_contact_reactions(const double *k, const double *q, const double *P, double *reaction);

/* reaction[joints][3]: impulse x, y (N s) and moment of impulse (N m s) on the joint's outboard link, but for what impulses of
 * the contacts add, from q[nq] and the jumps du[nu] and impulses Lambda[rows] of an impact */
typedef void ccgen_impulse_reactions(const double *k, const double *q, const double *du, const double *Lambda,
                                     double *reaction);

/* f[nu] = M u_dot + h: generalized forces, besides those of the effects, that the open chain needs for a motion */
typedef void ccgen_inverse_dynamics(const double *k, const double *q, const double *u, double t, const double *inputs,
                                    const double *u_dot, double *f);

/* power[1] (W) of the effects that have no potential, of driven joints too; NULL where there are none. From u_dot[nu] and
 * lambda[rows] that belong to the state */
typedef void ccgen_power(const double *k, const double *q, const double *u, double t, const double *inputs,
                         const double *u_dot, const double *lambda, double *power);

/* value[switches] of the switching functions, from the inputs but the sides; or value[latches] that effects would hold from now
 * on, from the scene's own inputs alone; see `switches` and `latches` below */
typedef void ccgen_switching(const double *k, const double *q, const double *u, double t, const double *inputs,
                             double *value);

/* value[indicators] of the expressions whose zeros are events of the scene, rate[indicators] per second, and size[indicators]: rounding of a
 * value is a small multiple of the precision times that. From scales[2], a length of the mechanism (m) and a time (s). */
typedef void ccgen_indicators(const double *k, const double *q, const double *u, double t, const double *scales,
                              double *value, double *rate, double *size);

/* value[event_values] that events set parameters to where they come */
typedef void ccgen_event_values(const double *k, const double *q, const double *u, double t, double *value);

/* What a parameter may be, beside finite */
enum ccgen_domain { CCGEN_ANY, CCGEN_NOT_NEGATIVE, CCGEN_POSITIVE, CCGEN_FROM_0_TO_1, CCGEN_OFF_OR_ON };

/* relative[drives] (rad/s^2 or m/s^2): prescribed accelerations of the driven joints */
typedef void ccgen_prescribed(const double *k, double t, const double *inputs, double *relative);

/* functions of the configuration alone: out[...] from q[nq] */
typedef void ccgen_of_q(const double *k, const double *q, double *out);

/* functions of the state: out[...] from q[nq], u[nu] */
typedef void ccgen_of_state(const double *k, const double *q, const double *u, double *out);

/* f[nu] = N^T P from q[nq] and normal impulses P[contacts] (N s) */
typedef void ccgen_contact_impulse(const double *k, const double *q, const double *P, double *f);

/* What impulses of the contacts change, loops held shut, for `count` columns of them: du[count][nu] and rates[count][contacts],
 * N du, from q[nq] and P[count][contacts] (N s, N m s); where there is slip_impulse, the tangential impulses lie behind the
 * normal ones in each column of P, and T du behind N du in each of rates. What depends on q alone is computed once. */
typedef int ccgen_contact_response(const double *k, const double *q, int count, const double *P, double *du,
                                   double *rates);

/* e[contacts]: coefficient of restitution of each contact */
typedef void ccgen_restitution(const double *k, double *e);

/* Derivatives of a model's functions, where it was asked for with them.
 *
 * A tangent is what an output changes by along one direction in the arguments, per unit. Directions come in blocks of `lanes`:
 * value i of lane l of block b at [(b * size + i) * lanes + l]. */
struct ccgen_arguments { /* what a function reads, or blocks of directions in it; its other members may be NULL */
    const double *k, *q, *u, *t, *inputs, *u_dot, *multipliers, *P, *f, *y;
    const double *cs; /* what `cosines` gives of q, so that the functions that accelerations take find it once; or NULL */
};

/* tangents[blocks][outputs][lanes], one output of the function behind the other, at the arguments `at`, along the directions
 * `by`. Returns 1 where a pivot of what is solved almost vanishes, else 0. */
typedef int ccgen_tangent(const struct ccgen_arguments *at, const struct ccgen_arguments *by, int blocks, double *tangents);

/* "constants": of k along p, which stands in the place of k. "residual_q", "residual_u", "residual_k" and "residual_t" (along t
 * and inputs): of f[nu] = A^T lambda - M u_dot - h and y[rows] = -A u_dot - dA/dt u, u_dot and lambda held; "jump": of
 * A^T lambda - M u and -A u, u held too where no direction moves it. "solve": du[nu] and Lambda[rows] of `impulse` along f
 * and y, where the blocks of y lie each behind that of f, as the residuals give them. "indicators": of their values alone. All others: of the function of that name. What is not listed is
 * zero. */
struct ccgen_named_tangent {
    const char *name;
    int outputs;
    ccgen_tangent *function;
};

struct ccgen_derivatives {
    int lanes, count;
    const struct ccgen_named_tangent *tangents; /* [count] */
    ccgen_tangent *residual_q, *residual_u, *residual_k, *residual_t, *solve, *prescribed; /* those; NULL where they are zero */
    int angles;          /* of which residuals and `solve` read cosines and sines */
    ccgen_of_q *cosines; /* [2][angles]: cosines, behind them sines; NULL where they read none */
};

struct ccgen_model {
    int version; /* CCGEN_CONTRACT_VERSION; checked when the model is loaded */
    const char *name;
    const char *hash; /* of the canonical scene; must match the package's data */
    int nq, nu, base, rows, links, joints, points, contacts, parameters, constants, inputs, drives;
    int switches; /* effects whose loads have kinks: as many inputs behind the scene's own say on which side of its kink each is:
                   * 1 where its switching function is positive, else 0 */
    int latches; /* values that effects hold: the last `latches` of the inputs. Each is set when a switching function becomes
                   * positive, and holds until that does so again */
    int told;           /* numbers that runs tell of effects by name */
    int lines;          /* that loads have the direction of: steps become short where the ends of one meet */
    int indicators;     /* expressions whose zeros are events of the scene */
    int event_values;   /* that they set */
    const int *partner; /* [rows]: the other row of the same cut pin, or the row itself */
    const int *row_held; /* [rows]: the parameter that gates each row, which is on where that is 1, or -1 where it always is; NULL
                          * where all always are */
    const int *sides;   /* [joints]: 1 where the outboard link is the joint's second, -1 where it is its first */
    const int *directions; /* [indicators]: 1 where rises through zero are events, -1 where falls are, 0 where both are */
    const int *rated;   /* [indicators]: whether `rate` is known; this, the last and the function NULL without indicators */
    const int *stops_at; /* [indicators]: at which of its events a run ends, 0: at none */
    const int *value_of, *value_to; /* [event_values]: which event sets each, and which parameter, -1: one that cannot be set */
    const int *value_within;        /* [event_values]: an enum ccgen_domain */
    const int *value_forgets; /* [event_values][2]: where that switches an effect, the first of its latches and how many, which
                               * are forgotten where it comes on. These four NULL without event_values, as `find_event_values` */
    const int *joint_of;     /* [indicators]: the joint that lets go or takes hold, -1: none; this and the next four NULL where none does */
    const int *gate_of;      /* [indicators]: the parameter that is 1 while it holds and 0 while it is open, */
    const int *held_before;  /* [indicators]: and what that is where the indicator is looked for */
    const int *change_by;    /* [indicators]: 0 a time, 1 a force, in whose place the indicator has -1, 2 the points of the joint
                              * that meet, where the indicator rises through zero while they are near, 3 what the indicator says */
    const double *limits;    /* [indicators][3]: a force (N) and an impulse (N s) in the joint, and how near (m) its points have to
                              * be for it to take hold; 0: none, or what the runtime says */
    const int *driven;  /* [drives][2]: coordinate of a driven joint, and the one that it is measured from or -1 */
    ccgen_constants *derive_constants;
    ccgen_acceleration *acceleration;
    ccgen_impulse *impulse;
    ccgen_reactions *reactions;
    ccgen_of_q *closure;          /* residual[rows], m */
    ccgen_of_state *closure_rate; /* A u [rows], m/s */
    ccgen_of_state *closure_bias; /* dA/dt u [rows], m/s^2 */
    ccgen_of_q *closure_jacobian; /* A[rows][nu] */
    ccgen_of_state *momentum;     /* M u [nu] of the open chain */
    ccgen_inverse_dynamics *inverse_dynamics;
    ccgen_power *power;
    ccgen_prescribed *prescribed;
    ccgen_of_q *poses;           /* [links][3]: x, y (m) of the link's frame, angle (rad) */
    ccgen_of_state *velocities;  /* [links][3]: velocity of the frame's origin (m/s), angular velocity (rad/s) */
    ccgen_of_q *point_positions; /* [points][2], m: joints first, then each link's named points */
    ccgen_of_state *energy;      /* [2]: kinetic, potential, J */
    ccgen_of_q *gaps;            /* [contacts], m, positive outside */
    ccgen_of_state *gap_rates;   /* N u [contacts], m/s */
    ccgen_of_state *gap_bias;    /* dN/dt u [contacts], m/s^2 */
    ccgen_contact_impulse *contact_impulse;
    ccgen_restitution *restitution;
    ccgen_of_state *slips;     /* T u [contacts], m/s, along the grounds; this and the next three NULL where all
                                       * are smooth */
    ccgen_of_state *slip_bias; /* dT/dt u [contacts], m/s^2 */
    ccgen_contact_impulse *slip_impulse;        /* T^T P from tangential impulses P[contacts] */
    ccgen_restitution *friction;                /* mu[contacts] */
    ccgen_contact_reactions *contact_reactions; /* NULL without contacts */
    ccgen_impulse_reactions *impulse_reactions; /* NULL without contacts and joints that let go or take hold */
    int lanes; /* states that the functions over lanes take side by side: the vector width of the machine compiled for */
    ccgen_acceleration_lanes *acceleration_lanes; /* this and the next two are in lanes.c, NULL where it is left out */
    ccgen_acceleration_states *acceleration_states;
    ccgen_stages *stages;
    ccgen_contact_response *contact_response; /* NULL without contacts */
    ccgen_switching *switching;               /* NULL without switches */
    const int *latched_at;     /* [latches]: which function that is; this and the next NULL without latches */
    ccgen_switching *latching; /* value[latches] that are set */
    ccgen_switching *outputs;  /* value[told], from all inputs; NULL without any */
    ccgen_indicators *indicate;
    ccgen_event_values *find_event_values;
    ccgen_of_q *reaches;       /* [lines][2], m: from the first end of each line to its second; NULL without any */
    const struct ccgen_derivatives *derivatives; /* in derivatives.c; NULL where they were not asked for */
};

#endif
