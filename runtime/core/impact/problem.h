/* Contacts that are struck together, as every law of impact sees them: rates, and what impulses change of them. */
#ifndef CCGEN_PROBLEM_H
#define CCGEN_PROBLEM_H

#include "base/arena.h"
#include "base/outcome.h"

struct impact_problem {
    int count, all;       /* contacts; rows: twice as many where there is friction */
    const double *e;      /* [count] restitution */
    const double *before; /* [all] rates before the impact, as the state has them */
    double energy;        /* kinetic, before (J) */
    double missed;        /* what impulses may miss Coulomb's law by where none meets it; 0 for as little as rounding */
    double *W;            /* [all][all] */
    double *rate;         /* [all] of the gaps, then sliding: before a step, and after it */
    double *mu;           /* [count] */
    double *b, *least, *P, *F;
    double *after;      /* [all] rates after a step */
    double *wanted;     /* [all] impulses of expansion, in proportion; changes of impulses */
    double *goal;       /* [count] work that they are to give back */
    double *kept;       /* [2 count + all] impulses of compression, and the rates after it */
    const double *from; /* or NULL: rates to whose energy impulses may not add */
    signed char *mode;
    struct arena *arena; /* for scratch */
};

/* Impulses that end the approach of k->rate offset by extra[count], or none where that is NULL, each normal one at least least[count];
 * they are added to total[2 count], normals first, and change the rates. */
enum outcome impact_step(struct impact_problem *k, const double *extra, const double *least, double *total);

/* Whether impulses total[2 count] add energy that rates `after` the impact tell of: more than rounding */
int adds_energy(const struct impact_problem *k, const double *after, const double *total);

/* Normal impulses P[n] summed as they load their contacts: each times the root of its entry in the diagonal of W[all][all] */
double load_of(int n, int all, const double *W, const double *P);

/* Smallest x > 0 with v x + a x^2 / 2 = work, where v >= 0: the impulse by which a contact that opens at v, and faster by a per impulse,
 * has given back that work (Stronge, Impact Mechanics, 2000, section 3.3); infinite where there is none */
double until_work(double v, double a, double work);

#endif
