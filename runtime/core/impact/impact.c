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
#include <stdlib.h>
#include <string.h>

#include "algebra/elimination.h"
#include "constraints/delassus.h"
#include "constraints/impulse.h"
#include "constraints/nullspace.h"
#include "constraints/refinement.h"
#include "impact/law.h"
#include "motion/projection.h"

static const double MISS = CCGEN_LIMIT(1e-14, 1e-6); /* of the rates before: rates after that miss more are corrected */
static const double DEPENDENT =
    CCGEN_LIMIT(1e-9, 1e-4); /* share of its row: less is left of a contact that others carry */
static const double ROUNDED = CCGEN_LIMIT(1e-6, 1e-3); /* of an impulse: a correction that is more is none */
static const double FAILED = 1e-3; /* of the largest rate before: impulses that miss their rates by more are none */
static const double ROUNDED_RATE = CCGEN_LIMIT(1e-12, 1e-4); /* of the fastest motion: rates below are rounding */
enum { CORRECTIONS = 2 };

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
    k.e = e;
    k.before = before;
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
    double *push = k.kept + 2 * c + rows, *rates = push + all, *f = rates + all, *du = f + 2 * n, *units = du + n;

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
    if ((outcome = delassus(s, q, count, set, columns, k.W, units, units + rows * width, push, rates, f)) ||
        (outcome = s->law->impulses(&k, P)))
        goto end;
    if ((outcome = jump(s, q, count, set, P, push, f, du)))
        goto end;
    for (size_t i = 0; i < n; i++)
        u_plus[i] += du[i];
    rates_of(s, q, u_plus, count, set, rates, k.after);
    for (int pass = 0; pass < CORRECTIONS && correct(&k, before, P, k.wanted); pass++) {
        add_columns(rows, n, k.wanted, columns, u_plus);
        rates_of(s, q, u_plus, count, set, rates, k.after);
    }
    if (without_effect(&k, s, u_minus, before))
        outcome = OUTCOME_JAMMED;
    else if (adds_energy(&k, k.after, P))
        outcome = OUTCOME_GAINED;
end:
    free(work);
    free(mode);
    return outcome;
}
