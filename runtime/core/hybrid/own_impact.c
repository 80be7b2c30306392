/* Impacts of loops with themselves.
 *
 * An impact near a place ignores closure rows that are almost lost there. The motion behind it has to satisfy them nevertheless: what that takes is an impact of the loop with itself, in the record with
 * impulses of zero.
 */
#include "hybrid/own_impact.h"

#include <math.h>
#include <string.h>

#include "base/tolerances.h"
#include "model/contacts.h"

enum outcome note_own_impact(struct phase *f, double *before, double loss)
{
    const struct system *s = f->s;
    const int contacts = s->model->contacts, n = s->n;
    const struct mark mark = s->arena->top;
    double *P = TAKE_ZEROS(s->arena, double, 2 * (size_t)contacts), *now = f->y;
    int count = 0, failed = s->arena->ran_out;
    if (!failed) {
        contact_gaps(s, before, f->gaps);
        for (int c = 0; c < contacts; c++)
            if (f->gaps[c] <= gap_tolerance(f, c))
                f->set[count++] = c;
        f->y = before;
        failed = record_state(f);
        f->y = now;
        failed = failed || /* in the air it is in no record */
                 (count && append_impact(&f->run->impacts, f->t, before + n, now + n, n, count, f->set, P, loss, 1.0,
                                         f->run->record.count)) ||
                 record_state(f);
    }
    give_back(s->arena, mark);
    return failed ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
}

enum outcome come_onto_branch(struct phase *f)
{
    struct system *s = f->s;
    const struct mark mark = s->arena->top;
    double *y = TAKE(s->arena, double, s->size), before[2], after[2];
    enum outcome outcome = s->arena->ran_out ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    if (!outcome) {
        memcpy(y, f->y, s->size * sizeof *y);
        outcome = strike_on_branch(f);
    }
    if (!outcome && s->branch) {
        s->model->energy(s->k, y, y + s->n, before);
        s->model->energy(s->k, f->y, f->y + s->n, after);
        const double loss = before[0] - after[0] + (before[1] - after[1]);
        const double known = f->run->tolerance.rtol * fmax(f->at.energy_in_motion, before[0]) +
                             ENERGY_ROUNDING * (before[0] + fabs(before[1]));
        if ((s->model->drives ? fabs(loss) : loss) > known) /* drives may add */
            outcome = note_own_impact(f, y, loss);
    }
    give_back(s->arena, mark);
    return outcome;
}
