/* Stronge's law: restitution squared is a ratio of work. */
#include "base/tolerances.h"
#include "impact/law.h"

#include <math.h>

#include "complementarity/friction.h"
#include "impact/expansion.h"
#include "impact/stronge_single.h"

/* Stronge's law at several contacts: after compression each gives back e^2 times the work that it has taken, or its part of what
 * has been lost in all, where friction that turned round within compression has made that less. */
static enum outcome restore(struct impact_problem *k, double *total)
{
    const int n = k->count;
    double goals = 0.0, lost = 0.0;
    const enum outcome outcome = impact_step(k, NULL, NULL, total);
    if (outcome)
        return outcome;
    for (int i = 0; i < k->all; i++)
        lost -= 0.5 * total[i] * (k->before[i] + k->rate[i]);
    for (int i = 0; i < n; i++) {
        k->wanted[i] = k->e[i] * k->P[i];
        k->goal[i] = k->e[i] * k->e[i] * fmax(0.0, -0.5 * k->P[i] * (k->before[i] + k->rate[i]));
        goals += k->goal[i];
    }
    for (int i = 0; i < n && goals > lost; i++)
        k->goal[i] *= fmax(lost, 0.0) / goals;
    struct expansion expansion = {n, k->all, k->W, k->mu, k->wanted, k->goal, k->rate, total, total + n, k->arena};
    return expand(&expansion) ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
}

/* Stronge's law at one contact, where the process of the impact is known. */
static enum outcome restore_one(struct impact_problem *k, double *total)
{
    const double smooth[4] = {k->W[0], 0.0, 0.0, 1.0}, rate[2] = {k->rate[0], k->all > 1 ? k->rate[1] : 0.0};
    if (stronge_single(k->all > 1 ? k->W : smooth, k->mu[0], k->e[0], rate, total, total + 1))
        return OUTCOME_JAMMED;
    for (int i = 0; i < k->all; i++) {
        const double normal = k->W[i * k->all] * total[0], tangent = k->all > 1 ? k->W[i * k->all + 1] * total[1] : 0.0;
        const double after = k->rate[i] + normal + tangent;
        k->rate[i] = fabs(after) <= CONSISTENT * (fabs(k->rate[i]) + fabs(normal) + fabs(tangent)) ? 0.0 : after;
    }
    return OUTCOME_DONE;
}

static enum outcome stronge_impulses(struct impact_problem *k, double *total)
{
    return k->count == 1 ? restore_one(k, total) : restore(k, total);
}

const struct impact_law stronge = {"stronge", stronge_impulses};
