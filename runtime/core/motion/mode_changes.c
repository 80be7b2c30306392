/* The switching functions of held contacts; see mode_changes.h. */
#include "motion/mode_changes.h"

#include <math.h>

#include "motion/derivative.h"

/* times length per second: what moves along its friction is not at its limit; more than what a decision takes as still */
static const double CREEP = 1e-9;

/* watched values of a contact besides its force */
static int tangential(int slide)
{
    return slide == STICKS ? 2 : slide != SMOOTH && slide != TOUCHES;
}

int watched(const struct system *s)
{
    const struct holding *h = s->holding;
    int count = h ? h->count : 0;
    for (int i = 0; i < holds(s); i++)
        count += tangential(h->slide[i]);
    return count;
}

struct loss watcher(const struct system *s, int index)
{
    const struct holding *h = s->holding;
    if (index < h->count)
        return (struct loss){h->set[index], h->slide[index] == TOUCHES ? STIRS : PULLS};
    index -= h->count;
    for (int i = 0; i < h->count; i++) {
        const int values = tangential(h->slide[i]);
        if (index < values)
            return (struct loss){h->set[i], values == 1 ? STOPS : index ? GIVES_FORWARD : GIVES_BACKWARD};
        index -= values;
    }
    return (struct loss){-1, PULLS};
}

enum outcome watch(struct system *s, double t, const double *y, double *dy, double *values)
{
    const struct holding *h = s->holding;
    const enum outcome outcome = system_derivative(s, t, y, dy);
    int count = h->count, row = h->count;
    for (int i = 0; i < h->count && !outcome; i++)
        h->peak[h->set[i]] = fmax(h->peak[h->set[i]], fabs(h->force[i]));
    for (int i = 0; i < h->count; i++)
        values[i] = h->slide[i] == TOUCHES ? h->least[i] - fabs(h->force[i]) : h->least[i] + h->force[i];
    if (s->friction)
        s->model->slips(s->k, y, y + s->n, h->slips);
    for (int i = 0; i < h->count; i++) {
        const int contact = h->set[i];
        if (h->slide[i] == STICKS) {
            const double limit = s->friction[contact] * h->force[i], held = h->force[row++];
            values[count++] = limit - held; /* pulled forward no harder than that: it gives backward */
            values[count++] = limit + held;
        } else if (tangential(h->slide[i])) { /* at the limit it is at rest, or creeps against its friction */
            const double creeps = h->slide[i] == LIMIT || h->slide[i] == -LIMIT ? CREEP * s->length : 0.0;
            values[count++] = against(h->slide[i]) * h->slips[contact] + creeps;
        }
    }
    return outcome;
}
