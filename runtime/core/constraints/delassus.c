/* The Delassus operator W = N M^-1 N^T, loops held shut (docs/theory, section 5): by one factorisation for all columns, or column by
 * column. */
#include "constraints/delassus.h"

#include <string.h>

#include "base/tolerances.h"
#include "constraints/branch.h"
#include "constraints/impulse.h"
#include "constraints/nullspace.h"
#include "model/contacts.h"

/* Column by column, where the joined function has not solved or digits are refined */
static enum outcome delassus_by_columns(struct system *s, const double *q, int count, const int *set, double *columns,
                                        double *W)
{
    const struct ccgen_model *m = s->model;
    const int all = s->friction ? 2 * count : count;
    const struct mark mark = s->arena->top;
    double *pushes = TAKE_ZEROS(s->arena, double, m->contacts), *rates = TAKE(s->arena, double, m->contacts);
    double *closed = TAKE_ZEROS(s->arena, double, m->rows), *multipliers = TAKE(s->arena, double, m->rows);
    double *f = TAKE(s->arena, double, s->n);
    enum outcome outcome = s->arena->ran_out ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    for (int j = 0; j < all && !outcome; j++) {
        double *column = columns + (size_t)j * s->n;
        const int contact = set[j % count];
        pushes[contact] = j < count ? lever_of(s, contact) : 1.0;
        (j < count ? m->contact_impulse : m->slip_impulse)(s->k, q, pushes, f);
        pushes[contact] = 0.0;
        outcome = system_impulse(s, q, f, closed, RANK_TOLERANCE, column, multipliers);
        for (int i = 0; i < all && !outcome; i++) {
            if (i == 0)
                contact_rates(s, q, column, rates);
            else if (i == count)
                m->slips(s->k, q, column, rates);
            W[i * all + j] = rates[set[i % count]];
        }
    }
    give_back(s->arena, mark);
    return outcome;
}

/* By the joined function, all at once; 0, or 1 where it has not solved. units[k][width of a column] are zeros at first. */
static int delassus_at_once(struct system *s, const double *q, int count, const int *set, double *units,
                            double *answers, double *columns, double *W)
{
    const struct ccgen_model *m = s->model;
    const int all = s->friction ? 2 * count : count, width = width_of(s);
    for (int j = 0; j < all; j++)
        units[(size_t)j * width + set[j % count] + (j < count ? 0 : m->contacts)] =
            j < count ? lever_of(s, set[j]) : 1.0;
    if (m->contact_response(s->k, q, all, units, columns, answers))
        return 1;
    for (int j = 0; j < all; j++)
        for (int i = 0; i < all; i++)
            W[i * all + j] = answers[(size_t)j * width + set[i % count] + (i < count ? 0 : m->contacts)] *
                             (i < count ? lever_of(s, set[i]) : 1.0);
    return 0;
}

enum outcome delassus(struct system *s, const double *q, int count, const int *set, double *columns, double *W)
{
    const int all = s->friction ? 2 * count : count;
    const struct mark mark = s->arena->top;
    double *units = TAKE_ZEROS(s->arena, double, ((size_t)all * width_of(s)));
    double *answers = TAKE(s->arena, double, ((size_t)all * width_of(s)));
    enum outcome outcome = s->arena->ran_out ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    if (!outcome &&
        (s->refine || is_place_on_branch(s, q) || delassus_at_once(s, q, count, set, units, answers, columns, W)))
        outcome = delassus_by_columns(s, q, count, set, columns, W);
    give_back(s->arena, mark);
    for (int i = 0; i < all && !outcome; i++)
        for (int j = 0; j < i; j++)
            W[i * all + j] = W[j * all + i] = 0.5 * (W[i * all + j] + W[j * all + i]);
    return outcome;
}

void give_way(int rows, double compliance, double *W)
{
    for (int i = 0; i < rows; i++)
        W[i * (rows + 1)] *= 1.0 + compliance;
}
