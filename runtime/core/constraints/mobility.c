/* Contacts whose gaps no motion can change: the part of their rows that the motions have which loops and driven joints leave. */
#include "constraints/mobility.h"

#include <math.h>
#include <string.h>

#include "base/tolerances.h"
#include "constraints/nullspace.h"
#include "model/contacts.h"

enum outcome movable_contacts(struct system *s, const double *q, int count, const int *set, char *moves)
{
    const size_t n = s->n, contacts = s->model->contacts;
    const struct mark mark = s->arena->top;
    double *motions = TAKE(s->arena, double, n *n), *motion = TAKE_ZEROS(s->arena, double, n);
    double *rates = TAKE(s->arena, double, contacts);
    double *whole = TAKE_ZEROS(s->arena, double, contacts), *left = TAKE_ZEROS(s->arena, double, contacts);
    const int rank = s->arena->ran_out ? -1 : free_motions(s, q, motions);
    for (size_t i = 0; rank >= 0 && i < n; i++) {
        motion[i] = s->unit[i];
        contact_rates(s, q, motion, rates);
        motion[i] = 0.0;
        for (size_t c = 0; c < contacts; c++)
            whole[c] += rates[c] * rates[c];
    }
    for (size_t j = 0; rank >= 0 && j < n - rank; j++) {
        contact_rates(s, q, motions + j * n, rates);
        for (size_t c = 0; c < contacts; c++)
            left[c] += rates[c] * rates[c];
    }
    for (int i = 0; rank >= 0 && i < count; i++)
        moves[i] = left[set[i]] > RANK_TOLERANCE * RANK_TOLERANCE * whole[set[i]];
    give_back(s->arena, mark);
    return rank < 0 ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
}
