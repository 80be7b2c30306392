/* Simultaneous impacts, loops held shut (docs/theory, section 5):
 *
 *     M (u+ - u-) = A^T Lambda + N^T P + T^T F,   A u+ = 0,
 *
 * by Newton's law, 0 <= P, 0 <= N u+ + e N u-, complementary; or by Poisson's, in two such steps: compression to the end of
 * all approach, then expansion with at least e times the impulses of compression; or by Stronge's, see `restore`. Friction:
 * |F| <= mu P, against the sliding at the end of each step. One solve of the impulsive equations per row gives a column of
 * M^-1 (N, T)^T, from which W = (N, T) M^-1 (N, T)^T follows.
 */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "contact.h"
#include "coulomb.h"
#include "friction.h"
#include "stronge.h"

static const double GAIN = CCGEN_LIMIT(1e-9, 1e-4);   /* of the energy of the jump: more than that is no rounding */
static const double EQUAL = CCGEN_LIMIT(1e-14, 1e-6); /* relative: work that is what it is to be */
static const double NOISE = CCGEN_LIMIT(1e-12, 1e-5); /* times length per second: speeds that are rounding */

enum { DOUBLINGS = 30, HALVINGS = 60 };

struct strike {
    int count, all;  /* contacts; rows: twice as many where there is friction */
    double *W;       /* [all][all] */
    double *rate;    /* [all] of the gaps, then sliding */
    double *mu;      /* [count] */
    double *b, *least, *P, *F;
    double *after;    /* [all] rates after a step */
    double *turned;   /* [all] rates at the end of compression */
    double *squeezed; /* [2 count] impulses of compression */
    double *wanted;   /* [count] of expansion */
    signed char *slide;
};

/* The impulses of one step at rough contacts, and the rates after it. Where contacts can wedge a mechanism that has come to rest,
 * any impulses large enough would do: those that stop it are the least. */
static enum outcome rough_step(struct strike *k, const double *least)
{
    const int n = k->count;
    struct rough rough = {n, k->W, k->b, k->rate + n, k->mu, k->slide, least};
    const int wrong = solve_friction(n, k->W, k->b, k->rate + n, k->mu, k->slide, least, k->P, k->F);
    if (wrong)
        return wrong == 1 ? OUTCOME_JAMMED : OUTCOME_REPEATS;
    if (n == 1 || !least)
        least_impulses(&rough, 1, k->P, k->F);
    rough.bn = k->rate;
    rates_after(&rough, k->P, k->F, k->after);
    memcpy(k->rate, k->after, k->all * sizeof *k->rate);
    return OUTCOME_DONE;
}

static enum outcome smooth_step(struct strike *k, const double *least)
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
static enum outcome step(struct strike *k, const double *extra, const double *least, double *total)
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

/* Energy that the impulses add: half their product with the rates before and after. It may not be positive. */
static int gains(const struct strike *k, double length, const double *before, const double *total)
{
    double gain = 0.0, scale = 0.0;
    for (int i = 0; i < k->all; i++) {
        gain += 0.5 * total[i] * (before[i] + k->rate[i]);
        scale += fabs(total[i]) * (GAIN * (fabs(before[i]) + fabs(k->rate[i])) + NOISE * length);
    }
    return gain > scale;
}

/* Work of the normal impulses P in a step that brings their rates from `before` to k->rate */
static double normal_work(const struct strike *k, const double *P, const double *before)
{
    double work = 0.0;
    for (int i = 0; i < k->count; i++)
        work += 0.5 * P[i] * (before[i] + k->rate[i]);
    return work;
}

/* Expansion with at least `part` times k->wanted: what its normal impulses give back, or a negative number where it has no
 * solution. The rates are those after it, total[] the impulses of both steps. */
static double expand(struct strike *k, double part, double *total)
{
    memcpy(k->rate, k->turned, k->all * sizeof *k->rate);
    memcpy(total, k->squeezed, 2 * k->count * sizeof *total);
    for (int i = 0; i < k->count; i++)
        k->least[i] = part * k->wanted[i];
    return step(k, NULL, k->least, total) ? -1.0 : normal_work(k, k->P, k->turned);
}

/* Stronge's law at several contacts: in expansion at least x e times the impulses of compression, x such that normal impulses
 * give back in all the sum over contacts of e^2 times the work that each has taken, or as much of it as adds no energy. */
static enum outcome restore(struct strike *k, double length, const double *e, const double *before, double *total)
{
    const int n = k->count;
    double goal = 0.0;
    const enum outcome outcome = step(k, NULL, NULL, total);
    memcpy(k->turned, k->rate, k->all * sizeof *k->turned);
    memcpy(k->squeezed, total, 2 * n * sizeof *total);
    for (int i = 0; i < n && !outcome; i++) {
        goal += e[i] * e[i] * fmax(0.0, -0.5 * k->P[i] * (before[i] + k->rate[i]));
        k->wanted[i] = e[i] * k->P[i];
    }
    if (outcome || !(goal > 0.0))
        return outcome;
    double low = 0.0, high = 1.0, given = expand(k, high, total);
    if (fabs(given - goal) <= EQUAL * goal && !gains(k, length, before, total))
        return OUTCOME_DONE;
    for (int i = 0; i < DOUBLINGS && given >= 0.0 && given < goal && !gains(k, length, before, total); i++)
        given = expand(k, high *= 2.0, total);
    for (int i = 0; i < HALVINGS; i++) {
        const double middle = 0.5 * (low + high);
        given = expand(k, middle, total);
        *(given < 0.0 || given > goal || gains(k, length, before, total) ? &high : &low) = middle;
    }
    return expand(k, low, total) < 0.0 ? OUTCOME_JAMMED : OUTCOME_DONE;
}

/* Stronge's law at one contact, where the process of the impact is known. */
static enum outcome restore_one(struct strike *k, double e, double *total)
{
    const double smooth[4] = {k->W[0], 0.0, 0.0, 1.0}, rate[2] = {k->rate[0], k->all > 1 ? k->rate[1] : 0.0};
    if (stronge_single(k->all > 1 ? k->W : smooth, k->mu[0], e, rate, total, total + 1))
        return OUTCOME_JAMMED;
    for (int i = 0; i < k->all; i++)
        k->rate[i] += k->W[i * k->all] * total[0] + (k->all > 1 ? k->W[i * k->all + 1] * total[1] : 0.0);
    return OUTCOME_DONE;
}

static enum outcome solve(struct strike *k, const struct system *s, const double *e, const double *before, double *total)
{
    const int n = k->count;
    memset(total, 0, 2 * n * sizeof *total);
    if (s->law == LAW_STRONGE)
        return n == 1 ? restore_one(k, e[0], total) : restore(k, s->length, e, before, total);
    for (int i = 0; i < n; i++)
        k->least[i] = e[i] * before[i];
    if (s->law == LAW_NEWTON)
        return step(k, k->least, NULL, total);
    const enum outcome outcome = step(k, NULL, NULL, total);
    for (int i = 0; i < n; i++)
        k->least[i] = e[i] * k->P[i];
    return outcome ? outcome : step(k, NULL, k->least, total);
}

enum outcome impact(struct system *s, const double *q, const double *u_minus, int count, const int *set, const double *e,
                    double *u_plus, double *P)
{
    const struct ccgen_model *m = s->model;
    const size_t n = s->n, c = count, all = m->contacts, rows = s->friction ? 2 * c : c;
    enum outcome outcome = OUTCOME_NO_MEMORY;
    double *work = calloc(rows * rows + rows * n + 4 * rows + 8 * c + 2 * all + n + 1, sizeof *work);
    signed char *slide = calloc(c + 1, 1);
    if (!work || !slide)
        goto end;
    struct strike k = {.count = count, .all = (int)rows, .W = work, .slide = slide};
    double *columns = work + rows * rows, *before = columns + rows * n;
    k.rate = before + rows;
    k.mu = k.rate + rows;
    k.b = k.mu + c;
    k.least = k.b + c;
    k.P = k.least + c;
    k.F = k.P + c;
    k.after = k.F + c;
    k.turned = k.after + rows;
    k.squeezed = k.turned + rows;
    k.wanted = k.squeezed + 2 * c;
    double *push = k.wanted + c, *rates = push + all, *f = rates + all;

    memcpy(u_plus, u_minus, n * sizeof *u_plus);
    if ((outcome = project_velocity(s, q, u_plus)))
        goto end;
    for (int side = 0; side < 2; side++) {
        double *target = side ? k.rate : before;
        const double *u = side ? u_plus : u_minus;
        m->gap_rates(s->k, q, u, rates);
        for (size_t i = 0; i < c; i++)
            target[i] = rates[set[i]];
        if (s->friction)
            m->slips(s->k, q, u, rates);
        for (size_t i = c; i < rows; i++)
            target[i] = rates[set[i - c]];
    }
    for (size_t i = 0; i < c && s->friction; i++)
        k.mu[i] = s->friction[set[i]];
    if ((outcome = compliance(s, q, count, set, columns, k.W, push, rates, f)) ||
        (outcome = solve(&k, s, e, before, P)))
        goto end;
    if (gains(&k, s->length, before, P))
        outcome = OUTCOME_GAINED;
    for (size_t j = 0; j < rows; j++)
        for (size_t i = 0; i < n; i++)
            u_plus[i] += P[j] * columns[j * n + i];
end:
    free(work);
    free(slide);
    return outcome;
}
