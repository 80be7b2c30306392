/* Newton's law: restitution is a ratio of speeds, 0 <= P, 0 <= N u+ + e N u-, complementary (docs/theory, eq. 5.4). */
#include "impact/law.h"

#include <string.h>

/* Newton's law. Friction may leave it several motions: where the first adds energy, one is looked for that does not. */
static enum outcome newton_impulses(struct impact_problem *k, double *total)
{
    double *approach = k->wanted;
    for (int i = 0; i < k->count; i++)
        k->least[i] = k->e[i] * k->before[i];
    memcpy(approach, k->rate, k->all * sizeof *approach);
    const enum outcome outcome = impact_step(k, k->least, NULL, total);
    if (outcome || !adds_energy(k, k->rate, total))
        return outcome;
    memcpy(k->rate, approach, k->all * sizeof *approach);
    memset(total, 0, 2 * k->count * sizeof *total);
    k->from = approach;
    return impact_step(k, k->least, NULL, total) ? OUTCOME_GAINED : OUTCOME_DONE;
}

const struct impact_law newton = {"newton", newton_impulses};
