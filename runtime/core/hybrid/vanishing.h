/* Forces of held contacts that vanish together; see vanishing.c. */
#ifndef CCGEN_VANISHING_H
#define CCGEN_VANISHING_H

#include "motion/switching.h"
#include "steps/step.h"

struct vanishing {
    double
        ahead; /* s: how far the held motion has been followed, to f->y1; 0: at most the force that is lost vanishes */
    double noise;  /* m/s^2: what accelerations of gaps by contact forces are known to */
    char *zero;    /* [contacts] whose force vanishes */
    double *force; /* [2 contacts] N, at the event: normal forces, and tangential ones below them */
};

/* What gaps are known to accelerate by (m/s^2), of the contacts `set` with compliances W[i * step]: rounding of the forces that
 * have held contacts closed since nothing was held, or since the last impact at which no closure row was nearly dependent */
double force_noise(const struct system *s, int count, const int *set, const double *W, int step);

/* The forces that vanish at the event `loss` at (t, y), with what has been held up to now still held, and the state a little
 * later, as if it were held on; where that cannot be computed, v->ahead is 0, and only an
 * interruption is an outcome. */
enum outcome find_vanishing(struct phase *f, struct mode_change loss, struct vanishing *v);

#endif
