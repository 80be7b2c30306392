/* How a run or a step of it ended. */
#ifndef CCGEN_OUTCOME_H
#define CCGEN_OUTCOME_H

/* How a run or a step of it ended. Texts for people are made from these in Python. */
enum outcome {
    OUTCOME_DONE = 0,
    OUTCOME_NOT_FINITE,     /* an acceleration is not a finite number */
    OUTCOME_STEP_TOO_SMALL, /* the error test fails at the smallest step that still moves time */
    OUTCOME_NOT_CLOSED,     /* projection onto the closure does not converge */
    OUTCOME_ACCUMULATION,   /* events accumulate at one instant, and do not hand over to contact */
    OUTCOME_REPEATS,        /* impacts at one instant do not come to an end */
    OUTCOME_BUDGET,         /* step budget spent */
    OUTCOME_CROWDED,        /* the steps or events that a simulated second may have are spent */
    OUTCOME_JAMMED,         /* contacts with friction have no forces, or more than one choice of them (Painleve) */
    OUTCOME_GAINED,         /* an impact by this law would add energy */
    OUTCOME_ESCAPED,        /* a point gets behind its surface, however short the step */
    OUTCOME_INTERRUPTED,
    OUTCOME_NO_MEMORY,
    OUTCOME_NO_CONVERGENCE, /* the iteration of an implicit method does not converge */
    OUTCOME_NOT_KEPT,       /* a step of fixed length gains or loses too much of the energy */
    OUTCOME_INEXACT         /* masses differ so much that no digit of an acceleration or jump is sure */
};

#endif
