/* Stronge's law: restitution squared is a ratio of work. */
#include "impact/law.h"

#include <math.h>
#include <string.h>

#include "complementarity/coulomb.h"
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
    if (k->all == 1) {
        k->rate[0] += k->W[0] * total[0];
        return OUTCOME_DONE;
    }
    struct friction_problem one = {
        .n = 1, .W = k->W, .bn = k->rate, .bt = k->rate + 1, .mu = k->mu, .mode = k->mode, .arena = k->arena};
    const struct mark mark = k->arena->top;
    const int prepared = !prepare_friction(&one);
    if (prepared) {
        rates_after(&one, total, total + 1, k->after);
        memcpy(k->rate, k->after, 2 * sizeof *k->rate);
    }
    give_back(k->arena, mark);
    return prepared ? OUTCOME_DONE : OUTCOME_NO_MEMORY;
}

static enum outcome stronge_impulses(struct impact_problem *k, double *total)
{
    return k->count == 1 ? restore_one(k, total) : restore(k, total);
}

const struct impact_law stronge = {"stronge", stronge_impulses};
