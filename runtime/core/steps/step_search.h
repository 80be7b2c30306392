/* What searches through a step share: what they look at along its dense output, and where that comes to zero. */
#ifndef CCGEN_STEP_SEARCH_H
#define CCGEN_STEP_SEARCH_H

#include "methods/method.h"
#include "steps/event.h"

enum {
    SAMPLES = 8,   /* pieces of a step, and of a window */
    HALVINGS = 40, /* in search of where a value that is zero comes to be positive */
    CLOSER = 12    /* times that a piece is parted */
};

/* All gaps and their rates at a part of the step, or all watched values of effects and their slopes over it */
struct sampled {
    double theta;
    double *value, *rate; /* [sampled_count] */
};

struct search {
    struct system *s;
    const struct method *method;
    const double *steps;
    double t, h;
    double *y, *dy;                                   /* [size] at a sample */
    double *values;                                   /* [all] all gaps, rates or watched values there */
    void (*watch)(struct search *, double, double *); /* all watched values at a part of the step */
    double *velocities;                               /* [links][3] */
    /* what is sampled at a part of the step, and its first event between two samples */
    void (*take_sample)(struct search *, double, struct sampled *);
    struct event (*first_in_piece)(struct search *, const struct sampled *, const struct sampled *);
    int sampled_count;
    double span;                    /* of the step in the unit of rates */
    struct sampled ends[3];         /* of two pieces in a row */
    struct sampled between[CLOSER]; /* of pieces that are parted, so many times */
    double *samples;                /* [SAMPLES + 1][watched] watched values in a window */
    double *noise;                  /* [switches] what those of effects are known to */
    double slow;                    /* times extent: a closed contact is not falling before its rate is beyond this */
    int bears;                      /* whether events are asked for of contacts that come to bear in place of others */
    long interval_count;
};

/* Pieces in which to look at the step, an even number: gaps come and go with every turn of a link, however long the step */
long interval_count(struct search *search);

/* the watched values of held contacts at theta; what cannot be computed counts as lost */
void watch_contacts(struct search *search, double theta, double *values);

/* and of effects with kinks */
void watch_effects(struct search *search, double theta, double *values);

/* one of those that the search watches */
double one_watched(struct search *search, int index, double theta);

/* Root of f between a and b, where it has the signs of fa and fb: false position with the Illinois modification, and
 * bisection whenever a step shrinks the bracket by less than half in three. The returned end is the one with fb's sign. */
double root_between(struct search *search, double (*f)(struct search *, int, double), int index, double a, double fa,
                    double b, double fb);

/* Where watched value `index`, which is negative at theta b, comes to be so: part of the step. A value that is zero at a, as the sliding of what begins to slide, may
 * become positive before it is lost. */
double first_negative(struct search *search, int index, double a, double at_a, double b, double at_b);

#endif
