/* Steps from rows of a record; see advance.c. */
#ifndef CCGEN_ADVANCE_H
#define CCGEN_ADVANCE_H

#include "interface/simulation.h"

/* Two rows of a run that follow each other, and how it went on between them */
struct stretch {
    const struct system *system;
    const struct method *method;
    struct tolerance tolerance;
    enum drift drift;
    double t[2];
    const double *q[2], *u[2]; /* [n] of both rows */
    int line;                  /* whether it went on by time stepping: states are on the line between the rows */
    int count;                 /* contacts that are held, */
    const int *set;            /* [count] which, */
    const signed char *mode;   /* [count] and how */
    const double *latched;     /* [latches] what effects hold */
};

/* From the first row (end 0) or the second by h, into y[size of a state]: by one step of the method, or in a model without contacts by as many as
 * the tolerance, unless it is zero, asks for; where the method has none, as beside a singular configuration, by collocation. */
enum outcome step_from(const struct stretch *w, int end, double h, double *y);

/* The state at t between the rows into y[size of a state], along the branch of the motion, if a singular configuration lies near that way and the branch is told, which *there_is says. */
enum outcome step_by_singularity(const struct stretch *w, double t, double *y, int *there_is);

#endif
