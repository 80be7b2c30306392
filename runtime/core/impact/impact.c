/* Simultaneous impacts, loops held shut (docs/theory, section 5):
 *
 *     M (u+ - u-) = A^T Lambda + N^T P + T^T F,   A u+ = 0,
 *
 * by the law of the system: law.h.
 * Friction: |F| <= mu P, against the sliding at the end of each step. One solve of the impulsive equations per row gives a
 * column of M^-1 (N, T)^T, from which W = (N, T) M^-1 (N, T)^T follows.
 */
#include "impact/impact.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "algebra/elimination.h"
#include "algebra/power_of_two.h"
#include "base/tolerances.h"
#include "constraints/delassus.h"
#include "constraints/impulse.h"
#include "constraints/mobility.h"
#include "constraints/nullspace.h"
#include "constraints/refinement.h"
#include "impact/law.h"
#include "motion/projection.h"
#include "model/contacts.h"

enum { CORRECTIONS = 2 };

/* Rates of the gaps of the contacts `set`, then of their sliding where there is friction */
static void rates_of(struct system *s, const double *q, const double *u, int count, const int *set, double *scratch,
                     double *rate)
{
    contact_rates(s, q, u, scratch);
    for (int i = 0; i < count; i++)
        rate[i] = scratch[set[i]];
    if (s->friction)
        s->model->slips(s->k, q, u, scratch);
    for (int i = 0; s->friction && i < count; i++)
        rate[count + i] = scratch[set[i]];
}

/* du[n] that all impulses P[2 count] give together. Where some of them hold each other through the links, rounding is of their
 * size, not of that of du: so it is not a sum of columns, and corrected for what the unreduced equations still miss. */
static enum outcome jump(struct system *s, const double *q, int count, const int *set, const double *P, double *du)
{
    const struct ccgen_model *m = s->model;
    const struct mark mark = s->arena->top;
    double *push = TAKE_ZEROS(s->arena, double, m->contacts);
    double *f = TAKE(s->arena, double, s->n), *g = TAKE(s->arena, double, s->n);
    double *closed = TAKE_ZEROS(s->arena, double, m->rows), *multipliers = TAKE(s->arena, double, m->rows);
    enum outcome outcome = OUTCOME_NO_MEMORY;
    if (s->arena->ran_out)
        goto end;
    for (int i = 0; i < count; i++)
        push[set[i]] = P[i] * lever_of(s, set[i]);
    m->contact_impulse(s->k, q, push, f);
    for (int i = 0; i < count; i++)
        push[set[i]] = P[count + i];
    if (s->friction)
        m->slip_impulse(s->k, q, push, g);
    for (int i = 0; i < s->n && s->friction; i++)
        f[i] += g[i];
    const long dependent = s->rank_deficient;
    const double inexact = s->refinement_residual;
    outcome = system_impulse(s, q, f, closed, RANK_TOLERANCE, du, multipliers);
    if (outcome || s->refine || s->rank_deficient > dependent)
        goto end;
    memcpy(g, du, s->n * sizeof *g);
    if (refine_impulse(s, q, f, closed, du, multipliers))
        memcpy(du, g, s->n * sizeof *g);
    s->refinement_residual = inexact;
end:
    give_back(s->arena, mark);
    return outcome;
}

/* Whether friction holds contact i, of the impulses P[2 count]: never without friction */
static int sticks(const struct impact_problem *k, const double *P, int i)
{
    return k->all > k->count && k->rate[k->count + i] == 0.0 && fabs(P[k->count + i]) < k->mu[i] * P[i];
}

/* Friction per normal impulse of a contact where that stays what it is; 0 where it sticks */
static double friction_ratio(const struct impact_problem *k, const double *P, int i)
{
    return k->all == k->count || sticks(k, P, i) || !(P[i] > 0.0) ? 0.0 : P[k->count + i] / P[i];
}

/* Correct the impulses P[2 count] where the velocities that they give, of the rates k->after, miss the rates that were solved for:
 * of the contacts that push, and of the sliding of those that stick. W is known to the digits that masses leave, rates
 * to all. The changes are change[all]; whether there is any */
static int correct(const struct impact_problem *k, const double *before, double *P, double *change)
{
    const size_t n = k->count, all = k->all;
    const struct mark mark = k->arena->top;
    double *A = TAKE(k->arena, double, (all * all)), *x = TAKE(k->arena, double, all);
    int *column = TAKE(k->arena, int, all), *order = TAKE(k->arena, int, all), m = 0, rank = 0;
    double speed = 0.0, miss = 0.0, largest = 0.0, load = 0.0;
    memset(change, 0, all * sizeof *change);
    for (size_t i = 0; !k->arena->ran_out && i < all; i++) {
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
    if (miss > RATES_MISSED * speed)
        rank = eliminate_dependent(m, m, A, x, order, DEPENDENT_PIVOT);
    for (int b = 0; b < rank; b++)
        largest = fmax(largest, fabs(x[b]));
    rank = largest > CORRECTED_IMPULSE * load ? 0 : rank;
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
    give_back(k->arena, mark);
    return rank > 0;
}

/* Whether the impulses do not bring about the rates after that they were solved for, so far as not even their first digits are
 * known: where nothing lets the contacts give way, as before a joint whose motion is prescribed, W is rounding. */
static int without_effect(const struct impact_problem *k, const struct system *s, const int *set, const double *u,
                          const double *before)
{
    double speed = 0.0, miss = 0.0; /* times extent per second */
    for (int i = 0; i < k->all; i++) {
        const double extent = s->extent[set[i % k->count]];
        speed = fmax(speed, fabs(before[i]) / extent);
        miss = fmax(miss, fabs(k->after[i] - k->rate[i]) / extent);
    }
    return !(miss <= NO_EFFECT * speed || miss <= ROUNDED_RATE * fastest(s, u));
}

/* The law's impulses P[2 count], and the rates that they lead to: of the same problem with W and rates of about 1, which all limits
 * of the law are for. It is scaled by powers of two, without rounding. */
static enum outcome impulses_by_law(const struct impact_law *law, struct impact_problem *k, double *before, double *P)
{
    const int n = k->count, all = k->all;
    double largest = 0.0, fastest = 0.0;
    for (int i = 0; i < all; i++) {
        largest = fmax(largest, k->W[i * (all + 1)]);
        fastest = fmax(fastest, fmax(fabs(before[i]), fabs(k->rate[i])));
    }
    const double w = power_of_two(largest), speed = power_of_two(fastest), energy = k->energy;
    multiply(all * all, 1.0 / w, k->W);
    multiply(all, 1.0 / speed, before);
    multiply(all, 1.0 / speed, k->rate);
    k->energy *= w / (speed * speed);
    const enum outcome outcome = law->impulses(k, P);
    k->energy = energy;
    multiply(all * all, w, k->W);
    multiply(all, speed, before);
    multiply(all, speed, k->rate);
    multiply(2 * n, speed / w, P);
    return outcome;
}

/* Whether masses hide what bounces: of the impulses P[2 count] that the law has found, of the contacts that push by more than the law may be missed by, and of
 * the friction that holds. What slides has friction in proportion, and is known from its normal impulse. Where none are `found`, all may push and hold that are there,
 * and what approaches bounces. */
static int hidden_bounce(const struct impact_problem *k, struct system *s, const double *q, const int *set,
                         const double *P, int found)
{
    const size_t n = k->count, all = k->all;
    const struct mark mark = k->arena->top;
    char *holds = TAKE_ZEROS(k->arena, char, all), *bounces = TAKE_ZEROS(k->arena, char, n);
    double load = 0.0;
    int any = 0;
    for (size_t i = 0; i < n && found; i++)
        load = fmax(load, sqrt(fmax(k->W[i * (all + 1)], 0.0)) * P[i]);
    for (size_t i = 0; i < n && !k->arena->ran_out; i++) {
        holds[i] = !found || sqrt(fmax(k->W[i * (all + 1)], 0.0)) * P[i] > CONSISTENT * load;
        if (all > n)
            holds[n + i] = holds[i] && (found ? sticks(k, P, (int)i) : k->mu[i] > 0.0);
        any |= bounces[i] = holds[i] && k->e[i] > 0.0 && (found || k->before[i] < 0.0);
    }
    const int hidden = any && !k->arena->ran_out && masses_hide(s, q, k->count, set, holds, bounces, k->W) >= 0;
    give_back(k->arena, mark);
    return hidden;
}

/* The law's impulses, or OUTCOME_INEXACT where none can be known: where masses hide what contacts give back, and where smooth ones have none, which have them
 * (docs/theory, section 5.2) */
static enum outcome impulses(struct impact_problem *k, struct system *s, const double *q, const int *set,
                             double *before, double *P)
{
    const enum outcome outcome = impulses_by_law(s->law, k, before, P);
    const int fails = outcome == OUTCOME_JAMMED || outcome == OUTCOME_REPEATS;
    if ((!outcome || fails) && hidden_bounce(k, s, q, set, P, !fails))
        return OUTCOME_INEXACT;
    return outcome == OUTCOME_REPEATS && !s->friction && !s->model->drives ? OUTCOME_INEXACT : outcome;
}

/* An impact of the contacts `count`, with room for its numbers */
static struct impact_problem take_problem(struct system *s, int count, const double *e)
{
    struct arena *arena = s->arena;
    const size_t c = count, rows = s->friction ? 2 * c : c;
    return (struct impact_problem){
        .count = count,
        .all = (int)rows,
        .e = e,
        .W = TAKE(arena, double, (rows * rows)),
        .rate = TAKE(arena, double, rows),
        .mu = TAKE_ZEROS(arena, double, c),
        .b = TAKE(arena, double, c),
        .least = TAKE(arena, double, c),
        .P = TAKE_ZEROS(arena, double, c),
        .F = TAKE_ZEROS(arena, double, c),
        .after = TAKE(arena, double, rows),
        .wanted = TAKE(arena, double, rows),
        .goal = TAKE(arena, double, c),
        .kept = TAKE(arena, double, 2 * c + rows),
        .mode = TAKE_ZEROS(arena, signed char, c),
        .arena = arena,
    };
}

/* u[n] += sum over j of weight[j] columns[j][n] */
static void add_columns(size_t rows, size_t n, const double *weight, const double *columns, double *u)
{
    for (size_t j = 0; j < rows; j++)
        for (size_t i = 0; i < n; i++)
            u[i] += weight[j] * columns[j * n + i];
}

enum outcome impact(struct system *s, const double *q, const double *u_minus, int count, const int *set,
                    const double *e, double *u_plus, double *P)
{
    const struct ccgen_model *m = s->model;
    const size_t n = s->n, c = count, rows = s->friction ? 2 * c : c;
    const struct mark mark = s->arena->top;
    struct impact_problem k = take_problem(s, count, e);
    double *columns = TAKE(s->arena, double, (rows * n)), *before = TAKE(s->arena, double, rows);
    double *rates = TAKE(s->arena, double, m->contacts);
    double *f = TAKE(s->arena, double, n), *du = TAKE(s->arena, double, n);
    enum outcome outcome = OUTCOME_NO_MEMORY;
    if (s->arena->ran_out)
        goto end;
    k.before = before;
    memcpy(u_plus, u_minus, n * sizeof *u_plus);
    memset(P, 0, 2 * c * sizeof *P);
    if ((outcome = project_velocity(s, q, u_plus)))
        goto end;
    rates_of(s, q, u_minus, count, set, rates, before);
    rates_of(s, q, u_plus, count, set, rates, k.rate);
    m->momentum(s->k, q, u_plus, f);
    for (size_t i = 0; i < n; i++)
        k.energy += 0.5 * u_plus[i] * f[i];
    for (size_t i = 0; i < c && s->friction; i++)
        k.mu[i] = s->friction[set[i]];
    k.missed = s->law_missed;
    outcome = delassus(s, q, count, set, columns, k.W);
    outcome = outcome ? outcome : impulses(&k, s, q, set, before, P);
    if (outcome)
        goto end;
    if ((outcome = jump(s, q, count, set, P, du)))
        goto end;
    for (size_t i = 0; i < n; i++)
        u_plus[i] += du[i];
    rates_of(s, q, u_plus, count, set, rates, k.after);
    for (int pass = 0; pass < CORRECTIONS && correct(&k, before, P, k.wanted); pass++) {
        add_columns(rows, n, k.wanted, columns, u_plus);
        rates_of(s, q, u_plus, count, set, rates, k.after);
    }
    if (without_effect(&k, s, set, u_minus, before))
        outcome = OUTCOME_JAMMED;
    else if (adds_energy(&k, k.after, P))
        outcome = hidden_bounce(&k, s, q, set, P, 0) ? OUTCOME_INEXACT : OUTCOME_GAINED;
    for (size_t i = 0; i < c; i++)
        P[i] *= lever_of(s, set[i]);
end:
    give_back(s->arena, mark);
    return outcome;
}

/* Work (J) of the impulses of friction F[count] */
static double friction_work(const struct system *s, const double *q, int count, const int *set, const double *F,
                            const double *u_minus, const double *u_plus, double *slips)
{
    double work = 0.0;
    for (int side = 0; s->friction && side < 2; side++) {
        s->model->slips(s->k, q, side ? u_plus : u_minus, slips);
        for (int i = 0; i < count; i++)
            work += 0.5 * F[i] * slips[set[i]];
    }
    return work;
}

double contacts_take(const struct system *s, const double *q, int count, const int *set, const double *P,
                     const double *before, const double *u_minus, const double *u_plus, double *scratch)
{
    double loss = 0.0;
    contact_rates(s, q, u_plus, scratch);
    for (int i = 0; i < count; i++)
        loss -= 0.5 * P[i] / lever_of(s, set[i]) * (before[set[i]] + scratch[set[i]]);
    return loss - friction_work(s, q, count, set, P + count, u_minus, u_plus, scratch);
}

double jump_loss(const struct system *s, const double *q, const double *u_minus, const double *u_plus, double *du,
                 double *momentum)
{
    double loss = 0.0;
    for (int i = 0; i < s->n; i++)
        du[i] = u_plus[i] - u_minus[i];
    s->model->momentum(s->k, q, du, momentum);
    for (int i = 0; i < s->n; i++)
        loss -= 0.5 * (u_minus[i] + u_plus[i]) * momentum[i];
    return loss;
}
