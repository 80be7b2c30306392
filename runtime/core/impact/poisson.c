/* Poisson's law: restitution is a ratio of impulses. Compression to the end of all approach, then expansion with at least e times its
 * impulses. */
#include "impact/law.h"

#include <string.h>

#include "impact/expansion.h"

/* Poisson's law: at least e times the impulses of compression. Friction may leave expansion as one step no impulses, only ones
 * that add energy, or much larger ones: it is then followed along the impulses. */
static enum outcome poisson_impulses(struct impact_problem *k, double *total)
{
    const int n = k->count;
    const enum outcome compression = impact_step(k, NULL, NULL, total);
    if (compression)
        return compression;
    double *P = k->kept, *rate = k->kept + 2 * n;
    memcpy(P, total, 2 * n * sizeof *P);
    memcpy(rate, k->rate, k->all * sizeof *rate);
    for (int i = 0; i < n; i++)
        k->wanted[i] = k->least[i] = k->e[i] * total[i];
    const enum outcome outcome = impact_step(k, NULL, k->least, total);
    if (k->all == n || (!outcome && load_of(n, k->all, k->W, k->P) <= MOST * load_of(n, k->all, k->W, P) &&
                        !adds_energy(k, k->rate, total)))
        return outcome;
    memcpy(total, P, 2 * n * sizeof *P);
    memcpy(k->rate, rate, k->all * sizeof *rate);
    struct expansion expansion = {n, k->all, k->W, k->mu, k->wanted, NULL, k->rate, total, total + n, k->arena};
    return expand(&expansion) ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
}

const struct impact_law poisson = {"poisson", poisson_impulses};
