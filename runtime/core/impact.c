/* Simultaneous impacts, loops held shut (docs/theory, section 5):
 *
 *     M (u+ - u-) = A^T Lambda + N^T P + T^T F,   A u+ = 0,
 *
 * by Newton's law, 0 <= P, 0 <= N u+ + e N u-, complementary; or by Poisson's, in two such steps: compression to the end of
 * all approach, then expansion with at least e times the impulses of compression. Friction: |F| <= mu P, against the sliding
 * at the end of each step. One solve of the impulsive equations per row gives a column of M^-1 (N, T)^T, from which
 * W = (N, T) M^-1 (N, T)^T follows.
 */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "contact.h"
#include "friction.h"

static const double GAIN = 1e-9; /* of the energy of the jump: more than that is no rounding */

struct strike {
    int count, all;  /* contacts; rows: twice as many where there is friction */
    double *W;       /* [all][all] */
    double *rate;    /* [all] of the gaps, then sliding */
    double *mu;      /* [count] */
    double *b, *least, *P, *F;
    signed char *slide;
};

/* Impulses of one step, with the normal rates offset by extra[count]; they change the rates. */
static enum outcome step(struct strike *k, const double *extra, const double *least, double *total)
{
    const int n = k->count;
    for (int i = 0; i < n; i++) {
        k->b[i] = k->rate[i] + (extra ? extra[i] : 0.0);
        for (int j = 0; least && k->all == n && j < n; j++)
            k->b[i] += k->W[i * n + j] * least[j];
    }
    memset(k->F, 0, n * sizeof *k->F);
    if (k->all > n) {
        const int wrong = solve_friction(n, k->W, k->b, k->rate + n, k->mu, k->slide, least, k->P, k->F);
        if (wrong)
            return wrong == 1 ? OUTCOME_JAMMED : OUTCOME_REPEATS;
    } else {
        if (solve_complementarity(n, k->W, k->b, k->P))
            return OUTCOME_REPEATS;
        for (int i = 0; least && i < n; i++)
            k->P[i] += least[i];
    }
    for (int i = 0; i < k->all; i++) {
        for (int j = 0; j < n; j++)
            k->rate[i] += k->W[i * k->all + j] * k->P[j] + (k->all > n ? k->W[i * k->all + n + j] * k->F[j] : 0.0);
    }
    for (int i = 0; i < n; i++) {
        total[i] += k->P[i];
        total[n + i] += k->F[i];
    }
    return OUTCOME_DONE;
}

static enum outcome solve(struct strike *k, enum law law, const double *e, const double *before, double *total)
{
    const int n = k->count;
    memset(total, 0, 2 * n * sizeof *total);
    for (int i = 0; i < n; i++)
        k->least[i] = e[i] * before[i];
    if (law == LAW_NEWTON)
        return step(k, k->least, NULL, total);
    const enum outcome outcome = step(k, NULL, NULL, total);
    for (int i = 0; i < n; i++)
        k->least[i] = e[i] * k->P[i];
    return outcome ? outcome : step(k, NULL, k->least, total);
}

/* Energy that the impulses add: half their product with the rates before and after. It may not be positive. */
static int gains(const struct strike *k, const double *before, const double *total)
{
    double gain = 0.0, scale = 0.0;
    for (int i = 0; i < k->all; i++) {
        gain += 0.5 * total[i] * (before[i] + k->rate[i]);
        scale += fabs(total[i]) * (fabs(before[i]) + fabs(k->rate[i]));
    }
    return gain > GAIN * scale;
}

enum outcome impact(struct system *s, const double *q, const double *u_minus, int count, const int *set, const double *e,
                    double *u_plus, double *P)
{
    const struct ccgen_model *m = s->model;
    const size_t n = s->n, c = count, all = m->contacts, rows = s->friction ? 2 * c : c;
    enum outcome outcome = OUTCOME_NO_MEMORY;
    double *work = calloc(rows * rows + rows * n + 2 * rows + 5 * c + 2 * all + n + 1, sizeof *work);
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
    double *push = k.F + c, *rates = push + all, *f = rates + all;

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
        (outcome = solve(&k, s->law, e, before, P)))
        goto end;
    if (gains(&k, before, P))
        outcome = OUTCOME_GAINED;
    for (size_t j = 0; j < rows; j++)
        for (size_t i = 0; i < n; i++)
            u_plus[i] += P[j] * columns[j * n + i];
end:
    free(work);
    free(slide);
    return outcome;
}
