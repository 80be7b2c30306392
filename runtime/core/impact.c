/* Simultaneous impacts by Newton's law, loops held shut (docs/theory, section 5):
 *
 *     M (u+ - u-) = A^T Lambda + N^T P,   A u+ = 0,   0 <= P,  0 <= N u+ + e N u-,  complementary.
 *
 * One solve of the impulsive equations per contact gives a column of M^-1 N^T, from which W = N M^-1 N^T follows.
 */
#include "core.h"

#include <stdlib.h>
#include <string.h>

enum outcome impact(struct system *s, const double *q, const double *u_minus, int count, const int *set, const double *e,
                    double *u_plus, double *P)
{
    const struct ccgen_model *m = s->model;
    const size_t n = s->n, c = count, all = m->contacts;
    enum outcome outcome = OUTCOME_NO_MEMORY;
    double *work = malloc((c * c + c * n + c + 3 * all + n) * sizeof *work);
    if (!work)
        return outcome;
    double *W = work, *columns = W + c * c, *b = columns + c * n, *rate = b + c, *before = rate + all, *push = before + all;
    double *f = push + all;

    m->gap_rates(s->k, q, u_minus, before);
    memcpy(u_plus, u_minus, n * sizeof *u_plus);
    if ((outcome = project_velocity(s, q, u_plus)))
        goto end;
    m->gap_rates(s->k, q, u_plus, rate);
    memset(s->rows, 0, m->rows * sizeof *s->rows);
    memset(push, 0, all * sizeof *push);
    for (size_t j = 0; j < c; j++)
        b[j] = rate[set[j]] + e[j] * before[set[j]];
    for (size_t j = 0; j < c; j++) {
        double *column = columns + j * n;
        push[set[j]] = 1.0;
        m->contact_impulse(s->k, q, push, f);
        push[set[j]] = 0.0;
        if ((outcome = system_impulse(s, q, f, s->rows, NEAREST, column, s->multipliers)))
            goto end;
        m->gap_rates(s->k, q, column, rate);
        for (size_t i = 0; i < c; i++)
            W[i * c + j] = rate[set[i]];
    }
    for (size_t i = 0; i < c; i++)
        for (size_t j = 0; j < i; j++)
            W[i * c + j] = W[j * c + i] = 0.5 * (W[i * c + j] + W[j * c + i]);
    if (solve_complementarity(count, W, b, P)) {
        outcome = OUTCOME_REPEATS;
        goto end;
    }
    for (size_t j = 0; j < c; j++)
        for (size_t i = 0; i < n; i++)
            u_plus[i] += P[j] * columns[j * n + i];
end:
    free(work);
    return outcome;
}
