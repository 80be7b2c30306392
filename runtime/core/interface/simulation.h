/* What a simulation consists of; ../../ccgen.h has its functions. */
#ifndef CCGEN_SIMULATION_H
#define CCGEN_SIMULATION_H

#include "hybrid/automaton.h"

#include "../../ccgen.h"

struct ccgen_simulation {
    struct system system;
    struct run run;
    struct phase phase;
    struct automaton automaton;
    struct arena arena; /* all memory of the simulation but the record */
    double time;        /* its characteristic time as asked for (s), or 0 */
    char *before;       /* the state before a stage */
    /* what follows from the parameters: [constants], and [contacts] each */
    double *k, *restitution, *friction, *lever, *extent;
};

/* Give a simulation other parameters, and the length, time and acceleration scale of `settings` that go with them; what else
 * they say is left. A run that has begun is over: reset it. */
void set_parameters(struct ccgen_simulation *s, const struct ccgen_settings *settings);

/* As ccgen_reset, where a run of another model has ended: effects hold latched[latches]. */
enum outcome reset_holding(struct ccgen_simulation *s, double t, const double *q, const double *u,
                           const double *latched);

/* How the loops of a system are kept closed */
void keep_closed(struct system *s, enum drift drift);

/* Go on to `until`, past all events. */
enum outcome simulate(struct ccgen_simulation *s, double until);

#endif
