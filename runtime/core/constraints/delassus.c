/* The Delassus operator W = N M^-1 N^T, loops held shut (docs/theory, section 5): by one factorisation for all columns, or column by
 * column. */
#include "constraints/delassus.h"

#include <string.h>

#include "base/tolerances.h"
#include "constraints/impulse.h"
#include "constraints/nullspace.h"

/* The same column by column, where the joined function has not solved or digits are refined */
static enum outcome delassus_by_columns(struct system *s, const double *q, int count, const int *set, double *columns,
                                        double *W, double *pushes, double *rates, double *f)
{
    const struct ccgen_model *m = s->model;
    const int all = s->friction ? 2 * count : count;
    memset(s->bias, 0, m->rows * sizeof *s->bias);
    memset(pushes, 0, m->contacts * sizeof *pushes);
    for (int j = 0; j < all; j++) {
        double *column = columns + (size_t)j * s->n;
        const int contact = set[j % count];
        pushes[contact] = 1.0;
        (j < count ? m->contact_impulse : m->slip_impulse)(s->k, q, pushes, f);
        pushes[contact] = 0.0;
        const enum outcome outcome = system_impulse(s, q, f, s->bias, RANK_TOLERANCE, column, s->multipliers);
        if (outcome)
            return outcome;
        for (int i = 0; i < all; i++) {
            if (i % count == 0)
                (i < count ? m->gap_rates : m->slips)(s->k, q, column, rates);
            W[i * all + j] = rates[set[i % count]];
        }
    }
    return OUTCOME_DONE;
}

enum outcome delassus(struct system *s, const double *q, int count, const int *set, double *columns, double *W,
                      double *units, double *answers, double *pushes, double *rates, double *f)
{
    const struct ccgen_model *m = s->model;
    const int all = s->friction ? 2 * count : count, width = width_of(s);
    int wrong = s->refine;
    if (!wrong) {
        memset(units, 0, (size_t)all * width * sizeof *units);
        for (int j = 0; j < all; j++)
            units[(size_t)j * width + set[j % count] + (j < count ? 0 : m->contacts)] = 1.0;
        wrong = m->contact_response(s->k, q, all, units, columns, answers);
        memset(units, 0, (size_t)all * width * sizeof *units);
    }
    for (int j = 0; j < all && !wrong; j++)
        for (int i = 0; i < all; i++)
            W[i * all + j] = answers[(size_t)j * width + set[i % count] + (i < count ? 0 : m->contacts)];
    const enum outcome outcome =
        wrong ? delassus_by_columns(s, q, count, set, columns, W, pushes, rates, f) : OUTCOME_DONE;
    for (int i = 0; i < all && !outcome; i++)
        for (int j = 0; j < i; j++)
            W[i * all + j] = W[j * all + i] = 0.5 * (W[i * all + j] + W[j * all + i]);
    return outcome;
}
