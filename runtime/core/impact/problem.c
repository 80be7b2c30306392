/* Steps of an impact; see problem.h. */
#include "impact/problem.h"

#include <math.h>
#include <string.h>

#include "base/tolerances.h"
#include "complementarity/complementarity.h"
#include "complementarity/coulomb.h"
#include "complementarity/friction.h"
#include "complementarity/least_impulses.h"
#include "complementarity/ways.h"
#include "constraints/delassus.h"

/* The same where none are found and the law may be missed: those of contacts that give way a little, if they miss it by no more */
static int solve_yielding(struct impact_problem *k, struct friction_problem *rough)
{
    struct arena *arena = k->arena;
    const struct mark mark = arena->top;
    const size_t rows = 2 * (size_t)k->count;
    const double *rigid = rough->W;
    double *W = TAKE(arena, double, rows *rows);
    int wrong = 1;
    for (double part = COMPLIANCE; wrong && !arena->ran_out && part <= SOFTEST; part *= SOFTER) {
        memcpy(W, rigid, rows * rows * sizeof *W);
        give_way((int)rows, part, W);
        rough->W = W;
        wrong = solve_friction(rough, k->P, k->F);
        rough->W = rigid;
        wrong = wrong || !(coulomb_miss(rough, k->P, k->F) <= k->missed);
    }
    give_back(arena, mark);
    return wrong;
}

/* The impulses of one step at rough contacts, and the rates after it; 0, or nonzero as `solve_friction` says */
static int solve_rough(struct impact_problem *k, struct friction_problem *rough)
{
    if (prepare_friction(rough))
        return 2;
    const int wrong = k->from ? least_impulses(rough, NOTHING, k->P, k->F) : solve_friction_least(rough, k->P, k->F);
    if (wrong && (k->from || !(k->missed > 0.0) || solve_yielding(k, rough)))
        return wrong;
    if (k->from)
        refine_impulses(rough, k->P, k->F);
    rough->bn = k->rate;
    rates_after(rough, k->P, k->F, k->after);
    memcpy(k->rate, k->after, k->all * sizeof *k->rate);
    return 0;
}

static enum outcome rough_step(struct impact_problem *k, const double *least)
{
    struct friction_problem rough = {.n = k->count,
                                     .W = k->W,
                                     .bn = k->b,
                                     .bt = k->rate + k->count,
                                     .mu = k->mu,
                                     .mode = k->mode,
                                     .least = least,
                                     .missed = k->missed,
                                     .from = k->from,
                                     .arena = k->arena};
    const struct mark mark = k->arena->top;
    const int wrong = solve_rough(k, &rough);
    give_back(k->arena, mark);
    return wrong == 1 ? OUTCOME_JAMMED : wrong ? OUTCOME_REPEATS : OUTCOME_DONE;
}

static enum outcome smooth_step(struct impact_problem *k, const double *least)
{
    const int n = k->count;
    for (int i = 0; least && i < n; i++)
        for (int j = 0; j < n; j++)
            k->b[i] += k->W[i * n + j] * least[j];
    if (solve_complementarity(k->arena, n, k->W, k->b, k->P))
        return OUTCOME_REPEATS;
    for (int i = 0; least && i < n; i++)
        k->P[i] += least[i];
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            k->rate[i] += k->W[i * n + j] * k->P[j];
    return OUTCOME_DONE;
}

/* Impulses of one step, with the normal rates offset by extra[count]; they change the rates. */
enum outcome impact_step(struct impact_problem *k, const double *extra, const double *least, double *total)
{
    const int n = k->count;
    for (int i = 0; i < n; i++)
        k->b[i] = k->rate[i] + (extra ? extra[i] : 0.0);
    memset(k->F, 0, n * sizeof *k->F);
    const enum outcome outcome = k->all > n ? rough_step(k, least) : smooth_step(k, least);
    for (int i = 0; i < n && !outcome; i++) {
        total[i] += k->P[i];
        total[n + i] += k->F[i];
    }
    return outcome;
}

/* Whether the impulses add energy: half their product with the rates before and after. What the rates found miss of those that the
 * velocities have (`after`) is rounding, and so is a part IMPACT_GAIN of the energy that there is. */
int adds_energy(const struct impact_problem *k, const double *after, const double *total)
{
    double gain = 0.0, rounding = IMPACT_GAIN * k->energy;
    for (int i = 0; i < k->all; i++) {
        gain += 0.5 * total[i] * (k->before[i] + after[i]);
        rounding += fabs(total[i] * (after[i] - k->rate[i]));
    }
    return gain > rounding;
}

double load_of(int n, int all, const double *W, const double *P)
{
    double load = 0.0;
    for (int i = 0; i < n; i++)
        load += sqrt(fmax(W[(size_t)i * (all + 1)], 0.0)) * P[i];
    return load;
}

double until_work(double v, double a, double work)
{
    const double square = v * v + 2.0 * a * work;
    return square < 0.0 || v + sqrt(square) == 0.0 ? INFINITY : 2.0 * work / (v + sqrt(square));
}
