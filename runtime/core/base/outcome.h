/* How a run or a step of it ended. */
#ifndef CCGEN_OUTCOME_H
#define CCGEN_OUTCOME_H

/* Texts for people are made from the names in Python. */
#define ALL_OUTCOMES(X)                                                                                                \
    X(DONE, "done")                                                                                                    \
    X(NOT_FINITE, "not_finite")         /* an acceleration is not a finite number */                                   \
    X(STEP_TOO_SMALL, "step_too_small") /* the error test fails at the smallest step that still moves time */          \
    X(NOT_CLOSED, "not_closed")         /* projection onto the closure does not converge */                            \
    X(NO_BRANCH, "no_branch")       /* rows depend on each other at the start, and its velocities lie on no branch */  \
    X(TWO_LINES, "two_lines")       /* a loop lies in a line where another all but does: no branch of both is told */  \
    X(ACCUMULATION, "accumulation") /* events accumulate at one instant, and do not hand over to contact */            \
    X(REPEATS, "repeats")           /* impacts at one instant do not come to an end */                                 \
    X(BUDGET, "budget")             /* step budget spent */                                                            \
    X(CROWDED, "crowded")           /* the steps or events that a characteristic time may have are spent */            \
    X(ENDLESS, "endless")           /* at the pace of its steps a run would not end within any budget */               \
    X(JAMMED, "jammed")   /* contacts with friction have no forces, or more than one choice of them (Painleve) */      \
    X(GAINED, "gained")   /* an impact by this law would add energy */                                                 \
    X(ESCAPED, "escaped") /* a point gets behind its surface, however short the step */                                \
    X(INTERRUPTED, "interrupted")                                                                                      \
    X(NO_MEMORY, "no_memory")                                                                                          \
    X(NO_CONVERGENCE, "no_convergence") /* the iteration of an implicit method does not converge */                    \
    X(NOT_KEPT, "not_kept")             /* a step of fixed length gains or loses too much of the energy */             \
    X(INEXACT, "inexact")               /* masses differ so much that no digit of an acceleration or jump is sure */   \
    X(TURNED_FAR, "turned_far")         /* an angle is so large that no digits are left of where links point */        \
    X(UNKNOWN_METHOD, "unknown_method") /* there is no method of that name */                                          \
    X(UNKNOWN_LAW, "unknown_law")       /* there is no law of impact of that name */                                   \
    X(BAD_SETTINGS, "bad_settings")     /* numbers that cannot be, or a time before that reached */                    \
    X(NOT_BEGUN, "not_begun")           /* a simulation that neither begins nor has a state */                         \
    X(OTHER_CONTRACT, "other_contract") /* the model was generated for another version of the contract */              \
    X(OTHER_STATE, "other_state")       /* a state of another model, method or precision */                            \
    X(NO_DERIVATIVES, "no_derivatives") /* the model was generated without them */                                     \
    X(DEPENDENT, "dependent") /* closure rows depend on each other, and there are no derivatives by all coordinates */ \
    X(CANNOT_SET, "cannot_set")           /* an event sets a parameter to what it cannot be */                         \
    X(OPENED, "opened")                   /* what an event has set opens the loops */                                  \
    X(INSIDE, "inside")                   /* what an event has set leaves a contact behind its surface */              \
    X(TOO_FAR, "too_far")                 /* a joint is to take hold whose points are too far apart */                 \
    X(SET_WITHOUT_END, "set_without_end") /* events set parameters again and again */

#define ENTRY(name, text) OUTCOME_##name,
enum outcome { ALL_OUTCOMES(ENTRY) OUTCOMES };
#undef ENTRY

#endif
