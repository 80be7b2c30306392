/* Simultaneous impacts, loops held shut (docs/theory, section 5):
 *
 *     M (u+ - u-) = A^T Lambda + N^T P + T^T F,   A u+ = 0,
 *
 * by Newton's law, 0 <= P, 0 <= N u+ + e N u-, complementary (eq. 5.4); or by Poisson's, in two such steps: compression to the
 * end of all approach, then expansion with at least e times the impulses of compression; or by Stronge's, see `restore`.
 * Friction: |F| <= mu P, against the sliding at the end of each step. One solve of the impulsive equations per row gives a
 * column of M^-1 (N, T)^T, from which W = (N, T) M^-1 (N, T)^T follows.
 */
#include "impact/impact.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "algebra/elimination.h"
#include "complementarity/complementarity.h"
#include "complementarity/friction.h"
#include "constraints/delassus.h"
#include "constraints/impulse.h"
#include "constraints/nullspace.h"
#include "constraints/refinement.h"
#include "impact/expansion.h"
#include "impact/stronge.h"
#include "motion/projection.h"

static const double GAIN = CCGEN_LIMIT(1e-13, 1e-5); /* of the kinetic energy: more than that is no rounding */
static const double MISS = CCGEN_LIMIT(1e-14, 1e-6); /* of the rates before: rates after that miss more are corrected */
static const double DEPENDENT =
    CCGEN_LIMIT(1e-9, 1e-4); /* share of its row: less is left of a contact that others carry */
static const double ROUNDED = CCGEN_LIMIT(1e-6, 1e-3); /* of an impulse: a correction that is more is none */
static const double FAILED = 1e-3; /* of the largest rate before: impulses that miss their rates by more are none */
static const double ROUNDED_RATE = CCGEN_LIMIT(1e-12, 1e-4); /* of the fastest motion: rates below are rounding */
enum { CORRECTIONS = 2 };

struct impact_problem {
    int count, all; /* contacts; rows: twice as many where there is friction */
    double *W;      /* [all][all] */
    double *rate;   /* [all] of the gaps, then sliding */
    double *mu;     /* [count] */
    double *b, *least, *P, *F;
    double *after;      /* [all] rates after a step */
    double *wanted;     /* [all] impulses of expansion, in proportion; changes of impulses */
    double *goal;       /* [count] work that they are to give back */
    double *kept;       /* [2 count + all] impulses of compression, and the rates after it */
    const double *from; /* or NULL: rates to whose energy impulses may not add */
    signed char *mode;
};

/* The impulses of one step at rough contacts, and the rates after it */
static enum outcome rough_step(struct impact_problem *k, const double *least)
{
    struct friction_problem rough = {k->count, k->W, k->b, k->rate + k->count, k->mu, k->mode, least, k->from};
    const int wrong = k->from ? least_impulses(&rough, NOTHING, k->P, k->F) : solve_friction_least(&rough, k->P, k->F);
    if (k->from && !wrong)
        refine_impulses(&rough, k->P, k->F);
    if (wrong)
        return wrong == 1 ? OUTCOME_JAMMED : OUTCOME_REPEATS;
    rough.bn = k->rate;
    rates_after(&rough, k->P, k->F, k->after);
    memcpy(k->rate, k->after, k->all * sizeof *k->rate);
    return OUTCOME_DONE;
}

static enum outcome smooth_step(struct impact_problem *k, const double *least)
{
    const int n = k->count;
    for (int i = 0; least && i < n; i++)
        for (int j = 0; j < n; j++)
            k->b[i] += k->W[i * n + j] * least[j];
    if (solve_complementarity(n, k->W, k->b, k->P))
        return OUTCOME_REPEATS;
    for (int i = 0; least && i < n; i++)
        k->P[i] += least[i];
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            k->rate[i] += k->W[i * n + j] * k->P[j];
    return OUTCOME_DONE;
}

/* Impulses of one step, with the normal rates offset by extra[count]; they change the rates. */
static enum outcome step(struct impact_problem *k, const double *extra, const double *least, double *total)
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
 * velocities have (`after`) is rounding, and so is a part GAIN of the energy that there is. Smooth contacts never add any. */
static int gains(const struct impact_problem *k, double energy, const double *before, const double *after,
                 const double *total)
{
    double gain = 0.0, rounding = GAIN * energy;
    for (int i = 0; i < k->all; i++) {
        gain += 0.5 * total[i] * (before[i] + after[i]);
        rounding += fabs(total[i] * (after[i] - k->rate[i]));
    }
    return k->all > k->count && gain > rounding;
}

/* Stronge's law at several contacts: after compression each gives back e^2 times the work that it has taken, or its part of what
 * has been lost in all, where friction that turned round within compression has made that less. */
static enum outcome restore(struct impact_problem *k, const double *e, const double *before, double *total)
{
    const int n = k->count;
    double goals = 0.0, lost = 0.0;
    const enum outcome outcome = step(k, NULL, NULL, total);
    if (outcome)
        return outcome;
    for (int i = 0; i < k->all; i++)
        lost -= 0.5 * total[i] * (before[i] + k->rate[i]);
    for (int i = 0; i < n; i++) {
        k->wanted[i] = e[i] * k->P[i];
        k->goal[i] = e[i] * e[i] * fmax(0.0, -0.5 * k->P[i] * (before[i] + k->rate[i]));
        goals += k->goal[i];
    }
    for (int i = 0; i < n && goals > lost; i++)
        k->goal[i] *= fmax(lost, 0.0) / goals;
    struct expansion expansion = {n, k->all, k->W, k->mu, k->wanted, k->goal, k->rate, total, total + n};
    return expand(&expansion) ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
}

/* Stronge's law at one contact, where the process of the impact is known. */
static enum outcome restore_one(struct impact_problem *k, double e, double *total)
{
    const double smooth[4] = {k->W[0], 0.0, 0.0, 1.0}, rate[2] = {k->rate[0], k->all > 1 ? k->rate[1] : 0.0};
    if (stronge_single(k->all > 1 ? k->W : smooth, k->mu[0], e, rate, total, total + 1))
        return OUTCOME_JAMMED;
    for (int i = 0; i < k->all; i++) {
        const double normal = k->W[i * k->all] * total[0], tangent = k->all > 1 ? k->W[i * k->all + 1] * total[1] : 0.0;
        const double after = k->rate[i] + normal + tangent;
        k->rate[i] = fabs(after) <= CONSISTENT * (fabs(k->rate[i]) + fabs(normal) + fabs(tangent)) ? 0.0 : after;
    }
    return OUTCOME_DONE;
}

/* Newton's law. Friction may leave it several motions: where the first adds energy, one is looked for that does not. */
static enum outcome rebound(struct impact_problem *k, double energy, const double *before, double *total)
{
    double *approach = k->wanted;
    memcpy(approach, k->rate, k->all * sizeof *approach);
    const enum outcome outcome = step(k, k->least, NULL, total);
    if (outcome || !gains(k, energy, before, k->rate, total))
        return outcome;
    memcpy(k->rate, approach, k->all * sizeof *approach);
    memset(total, 0, 2 * k->count * sizeof *total);
    k->from = approach;
    return step(k, k->least, NULL, total) ? OUTCOME_GAINED : OUTCOME_DONE;
}

/* Normal impulses summed as they load their contacts */
static double load_of(const struct impact_problem *k, const double *P)
{
    double load = 0.0;
    for (int i = 0; i < k->count; i++)
        load += sqrt(fmax(k->W[(size_t)i * (k->all + 1)], 0.0)) * P[i];
    return load;
}

/* Poisson's law: at least e times the impulses of compression. Friction may leave expansion as one step no impulses, only ones
 * that add energy, or much larger ones: it is then followed along the impulses. */
static enum outcome give_back(struct impact_problem *k, const double *e, double energy, const double *before,
                              double *total)
{
    const int n = k->count;
    const enum outcome compression = step(k, NULL, NULL, total);
    if (compression)
        return compression;
    double *P = k->kept, *rate = k->kept + 2 * n;
    memcpy(P, total, 2 * n * sizeof *P);
    memcpy(rate, k->rate, k->all * sizeof *rate);
    for (int i = 0; i < n; i++)
        k->wanted[i] = k->least[i] = e[i] * total[i];
    const enum outcome outcome = step(k, NULL, k->least, total);
    if (k->all == n ||
        (!outcome && load_of(k, k->P) <= MOST * load_of(k, P) && !gains(k, energy, before, k->rate, total)))
        return outcome;
    memcpy(total, P, 2 * n * sizeof *P);
    memcpy(k->rate, rate, k->all * sizeof *rate);
    struct expansion expansion = {n, k->all, k->W, k->mu, k->wanted, NULL, k->rate, total, total + n};
    return expand(&expansion) ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
}

static enum outcome solve(struct impact_problem *k, const struct system *s, const double *e, double energy,
                          const double *before, double *total)
{
    const int n = k->count;
    memset(total, 0, 2 * n * sizeof *total);
    if (s->law == LAW_STRONGE)
        return n == 1 ? restore_one(k, e[0], total) : restore(k, e, before, total);
    for (int i = 0; i < n; i++)
        k->least[i] = e[i] * before[i];
    if (s->law == LAW_NEWTON)
        return rebound(k, energy, before, total);
    return give_back(k, e, energy, before, total);
}

/* Rates of the gaps of the contacts `set`, then of their sliding where there is friction */
static void rates_of(struct system *s, const double *q, const double *u, int count, const int *set, double *scratch,
                     double *rate)
{
    s->model->gap_rates(s->k, q, u, scratch);
    for (int i = 0; i < count; i++)
        rate[i] = scratch[set[i]];
    if (s->friction)
        s->model->slips(s->k, q, u, scratch);
    for (int i = 0; s->friction && i < count; i++)
        rate[count + i] = scratch[set[i]];
}

/* du[n] that all impulses P[2 count] give together. Where some of them hold each other through the links, rounding is of their
 * size, not of that of du: so it is not a sum of columns, and corrected for what the unreduced equations still miss.
 * push[contacts] is zero, and so again afterwards; f[2 n] is scratch. */
static enum outcome jump(struct system *s, const double *q, int count, const int *set, const double *P, double *push,
                         double *f, double *du)
{
    const struct ccgen_model *m = s->model;
    double *g = f + s->n;
    for (int i = 0; i < count; i++)
        push[set[i]] = P[i];
    m->contact_impulse(s->k, q, push, f);
    for (int i = 0; i < count; i++)
        push[set[i]] = P[count + i];
    if (s->friction)
        m->slip_impulse(s->k, q, push, g);
    for (int i = 0; i < s->n && s->friction; i++)
        f[i] += g[i];
    for (int i = 0; i < count; i++)
        push[set[i]] = 0.0;
    memset(s->bias, 0, m->rows * sizeof *s->bias);
    const long dependent = s->rank_deficient;
    const double inexact = s->refinement_residual;
    const enum outcome outcome = system_impulse(s, q, f, s->bias, RANK_TOLERANCE, du, s->multipliers);
    if (outcome || s->refine || s->rank_deficient > dependent)
        return outcome;
    memcpy(g, du, s->n * sizeof *g);
    if (refine_impulse(s, q, f, s->bias, du, s->multipliers))
        memcpy(du, g, s->n * sizeof *g);
    s->refinement_residual = inexact;
    return OUTCOME_DONE;
}

/* Friction per normal impulse of a contact where that stays what it is; 0 where it sticks */
static double friction_ratio(const struct impact_problem *k, const double *P, int i)
{
    const double F = P[k->count + i];
    const int sticks = k->all == k->count || (k->rate[k->count + i] == 0.0 && fabs(F) < k->mu[i] * P[i]);
    return sticks || !(P[i] > 0.0) ? 0.0 : F / P[i];
}

/* Correct the impulses P[2 count] where the velocities that they give, of the rates k->after, miss the rates that were solved for:
 * of the contacts that push, and of the sliding of those that stick. W is known to the digits that masses leave, rates
 * to all. The changes are change[all]; whether there is any */
static int correct(const struct impact_problem *k, const double *before, double *P, double *change)
{
    const size_t n = k->count, all = k->all;
    double *A = malloc(((all + 1) * all + 1) * sizeof *A), *x = A + all * all, speed = 0.0, miss = 0.0;
    int *column = malloc((2 * all + 1) * sizeof *column), *order = column + all, m = 0, rank = 0;
    double largest = 0.0, load = 0.0;
    memset(change, 0, all * sizeof *change);
    for (size_t i = 0; A && column && i < all; i++) {
        if (P[i % n] > 0.0 && (i < n || (P[i] != 0.0 && friction_ratio(k, P, (int)(i % n)) == 0.0)))
            column[m++] = (int)i;
        speed = fmax(speed, fabs(before[i]));
        load = fmax(load, fabs(P[i]));
    }
    for (int a = 0; a < m; a++) {
        x[a] = k->rate[column[a]] - k->after[column[a]];
        miss = fmax(miss, fabs(x[a]));
        for (int b = 0; b < m; b++) {
            const double *row = k->W + column[a] * all,
                         ratio = (size_t)column[b] < n ? friction_ratio(k, P, column[b]) : 0.0;
            A[a * m + b] = row[column[b]] + (ratio != 0.0 ? ratio * row[n + column[b]] : 0.0);
        }
    }
    if (miss > MISS * speed)
        rank = eliminate_dependent(m, m, A, x, order, DEPENDENT);
    for (int b = 0; b < rank; b++)
        largest = fmax(largest, fabs(x[b]));
    rank = largest > ROUNDED * load ? 0 : rank;
    for (int b = 0; b < rank; b++) {
        const int i = column[order[b]];
        const double ratio = (size_t)i < n ? friction_ratio(k, P, i) : 0.0,
                     by = (size_t)i < n ? fmax(x[b], -P[i]) : x[b];
        change[i] += by;
        if (ratio != 0.0)
            change[n + i] += ratio * by;
    }
    for (size_t i = 0; i < all; i++)
        P[i] += change[i];
    free(A);
    free(column);
    return rank > 0;
}

/* Whether the impulses do not bring about the rates after that they were solved for, so far as not even their first digits are
 * known: where nothing lets the contacts give way, as before a joint whose motion is prescribed, W is rounding. */
static int without_effect(const struct impact_problem *k, const struct system *s, const double *u, const double *before)
{
    double speed = 0.0, miss = 0.0, fastest = 0.0;
    for (int i = 0; i < s->n; i++)
        fastest = fmax(fastest, fabs(u[i]) * (i < s->model->base ? 1.0 : s->length));
    for (int i = 0; i < k->all; i++) {
        speed = fmax(speed, fabs(before[i]));
        miss = fmax(miss, fabs(k->after[i] - k->rate[i]));
    }
    return !(miss <= FAILED * speed || miss <= ROUNDED_RATE * fastest);
}

enum outcome impact(struct system *s, const double *q, const double *u_minus, int count, const int *set,
                    const double *e, double *u_plus, double *P)
{
    const struct ccgen_model *m = s->model;
    const size_t n = s->n, c = count, all = m->contacts, rows = s->friction ? 2 * c : c;
    enum outcome outcome = OUTCOME_NO_MEMORY;
    const size_t width = width_of(s);
    double *work =
        calloc(rows * rows + rows * n + 5 * rows + 8 * c + 2 * all + 3 * n + 2 * rows * width + 1, sizeof *work);
    signed char *mode = calloc(c + 1, 1);
    if (!work || !mode)
        goto end;
    struct impact_problem k = {.count = count, .all = (int)rows, .W = work, .mode = mode};
    double *columns = work + rows * rows, *before = columns + rows * n;
    k.rate = before + rows;
    k.mu = k.rate + rows;
    k.b = k.mu + c;
    k.least = k.b + c;
    k.P = k.least + c;
    k.F = k.P + c;
    k.after = k.F + c;
    k.wanted = k.after + rows;
    k.goal = k.wanted + rows;
    k.kept = k.goal + c;
    double *push = k.kept + 2 * c + rows, *rates = push + all, *f = rates + all, *du = f + 2 * n, *units = du + n,
           energy = 0.0;

    memcpy(u_plus, u_minus, n * sizeof *u_plus);
    if ((outcome = project_velocity(s, q, u_plus)))
        goto end;
    rates_of(s, q, u_minus, count, set, rates, before);
    rates_of(s, q, u_plus, count, set, rates, k.rate);
    m->momentum(s->k, q, u_plus, f);
    for (size_t i = 0; i < n; i++)
        energy += 0.5 * u_plus[i] * f[i];
    for (size_t i = 0; i < c && s->friction; i++)
        k.mu[i] = s->friction[set[i]];
    if ((outcome = delassus(s, q, count, set, columns, k.W, units, units + rows * width, push, rates, f)) ||
        (outcome = solve(&k, s, e, energy, before, P)))
        goto end;
    if ((outcome = jump(s, q, count, set, P, push, f, du)))
        goto end;
    for (size_t i = 0; i < n; i++)
        u_plus[i] += du[i];
    rates_of(s, q, u_plus, count, set, rates, k.after);
    for (int pass = 0; pass < CORRECTIONS && correct(&k, before, P, k.wanted); pass++) {
        for (size_t j = 0; j < rows; j++)
            for (size_t i = 0; i < n; i++)
                u_plus[i] += k.wanted[j] * columns[j * n + i];
        rates_of(s, q, u_plus, count, set, rates, k.after);
    }
    if (without_effect(&k, s, u_minus, before))
        outcome = OUTCOME_JAMMED;
    else if (gains(&k, energy, before, k.after, P))
        outcome = OUTCOME_GAINED;
end:
    free(work);
    free(mode);
    return outcome;
}
