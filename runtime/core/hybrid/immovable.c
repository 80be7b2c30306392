/* Contacts that loops and driven joints leave no motion; see immovable.h. */
#include "hybrid/immovable.h"

#include "constraints/mobility.h"

enum outcome leave_out_immovable(struct phase *f, const double *q, int *count, int *set)
{
    struct system *s = f->s;
    const struct mark mark = s->arena->top;
    if (!s->model->drives || !*count)
        return OUTCOME_DONE;
    char *moves = TAKE(s->arena, char, *count);
    const enum outcome outcome = s->arena->ran_out ? OUTCOME_NO_MEMORY : movable_contacts(s, q, *count, set, moves);
    int left = 0;
    for (int i = 0; !outcome && i < *count; i++)
        if (moves[i] || f->rates[set[i]] < -rest_velocity(f, set[i]))
            set[left++] = set[i];
    *count = outcome ? *count : left;
    give_back(s->arena, mark);
    return outcome;
}
