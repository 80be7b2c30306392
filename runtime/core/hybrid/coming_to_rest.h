/* Whether what is to be held comes to rest, with loops closed and joints driven as they are; see coming_to_rest.c. */
#ifndef CCGEN_COMING_TO_REST_H
#define CCGEN_COMING_TO_REST_H

#include "hybrid/decision.h"

/* The state that a decision is about, and what closed contacts do in it */
struct before_rest {
    double *y;             /* [size] */
    double *rates, *slips; /* [contacts] */
    double rest_speed;     /* of the run */
    char *opens,
        *moves; /* [contacts] what has been found not to rest, by its gap, and along its ground: zeros at first */
};

/* Note the state; 0, or 1 when memory runs out. */
int note_before_rest(struct phase *f, struct before_rest *before);

/* Whether drives, or loops that all but lie in a line, move contacts against each other, and one that is held opened before: it may have to go on, rather than others come to rest
 * with it. */
int another_opens(const struct phase *f, const struct before_rest *before);

/* After d has been decided and what is held brought to rest, but for the sliding of what goes_on[d->count]: where that asks for too much, note one contact more that does
 * not rest and put the state back, and *again is set; nothing where there is none. */
enum outcome ask_for_less(struct phase *f, const struct decision *d, const struct before_rest *before,
                          const char *goes_on, int *again);

#endif
