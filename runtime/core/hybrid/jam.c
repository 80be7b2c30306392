/* Impacts without collision (docs/theory, section 5.11).
 *
 * Where a contact slides and friction presses it the harder the more it resists, there may be no forces that hold it (P. Painleve, 1895).
 * Real grounds give way a little: the force grows without bound in no time, until friction has stopped the sliding. What is left of
 * that as the ground gets stiffer is an impulse without any approach before it (F. Genot, B. Brogliato, "New results on Painleve
 * paradoxes", Eur. J. Mech. A/Solids 18, 1999). It is the impact of the closed contacts at e = 0 after an approach as slow as nothing: such an
 * impact has a solution for every approach, and as that goes to zero the impulse does not.
 */
#include "hybrid/jam.h"

#include <math.h>
#include <string.h>

#include "base/tolerances.h"
#include "constraints/delassus.h"
#include "constraints/impulse.h"
#include "hybrid/immovable.h"
#include "impact/impact.h"
#include "model/contacts.h"

/* What the impact works with */
struct room {
    int *set;
    signed char *mode;
    double *rows, *du, *approach, *u_plus, *momentum, *e, *P;
};

static int take_room(const struct system *s, struct room *r)
{
    struct arena *arena = s->arena;
    const size_t c = s->model->contacts, n = s->n;
    *r = (struct room){
        .set = TAKE(arena, int, c),
        .mode = TAKE(arena, signed char, c),
        .rows = TAKE_ZEROS(arena, double, s->model->rows + 2 * c),
        .du = TAKE(arena, double, n),
        .approach = TAKE(arena, double, n),
        .u_plus = TAKE(arena, double, n),
        .momentum = TAKE(arena, double, n),
        .e = TAKE_ZEROS(arena, double, c),
        .P = TAKE(arena, double, 2 * c),
    };
    return arena->ran_out;
}

/* Velocities r->approach at which the contacts r->set[count] approach by REST_SPEED */
static enum outcome approach(struct phase *f, struct room *r, int count)
{
    struct system *s = f->s;
    for (int i = 0; i < count; i++) {
        r->rows[s->model->rows + i] = -REST_SPEED * s->extent[r->set[i]] / s->time;
        r->mode[i] = FRICTIONLESS;
    }
    activate(s->active, count, r->set, r->mode);
    const enum outcome outcome = system_correction(s, f->y, 1, r->rows, RANK_TOLERANCE_PROJECTED, r->du);
    activate(s->active, 0, NULL, NULL);
    for (int i = 0; i < s->n && !outcome; i++)
        r->approach[i] = f->y[s->n + i] + r->du[i];
    return outcome;
}

static enum outcome strike_with(struct phase *f, struct room *r, int *contact)
{
    struct system *s = f->s;
    double *u = f->y + s->n;
    int count = 0;
    contact_gaps(s, f->y, f->gaps);
    contact_rates(s, f->y, u, f->rates);
    for (int c = 0; c < s->model->contacts; c++)
        if (f->gaps[c] <= SHUT * s->extent[c] && fabs(f->rates[c]) <= rest_velocity(f, c))
            r->set[count++] = c;
    const enum outcome outcome = leave_out_immovable(f, f->y, &count, r->set);
    if (outcome)
        return outcome;
    if (!count || approach(f, r, count) || impact(s, f->y, r->approach, count, r->set, r->e, r->u_plus, r->P))
        return interrupted(s->interruption, 0) ? OUTCOME_INTERRUPTED : OUTCOME_DONE;
    const double loss = jump_loss(s, f->y, u, r->u_plus, r->du, r->momentum), change = fastest(s, r->du);
    if ((!s->model->drives && !(loss >= 0.0)) || change * s->time <= COLLISION * REST_SPEED)
        return OUTCOME_DONE;
    struct impacts *impacts = &f->run->impacts;
    if (record_state(f) ||
        append_impact(impacts, f->t, u, r->u_plus, s->n, count, r->set, r->P, loss, 1.0, f->run->record.count))
        return OUTCOME_NO_MEMORY;
    memcpy(u, r->u_plus, s->n * sizeof *u);
    *contact = r->set[0];
    return record_state(f) ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
}

enum outcome strike_without_collision(struct phase *f, int *contact)
{
    const struct mark mark = f->s->arena->top;
    struct room r;
    *contact = -1;
    const enum outcome outcome = take_room(f->s, &r) ? OUTCOME_NO_MEMORY : strike_with(f, &r, contact);
    give_back(f->s->arena, mark);
    return outcome;
}

enum outcome find_jamming(struct phase *f, int *contact)
{
    struct system *s = f->s;
    const struct active_set *h = s->active;
    const struct mark mark = s->arena->top;
    const int count = active_count(s), rows = 2 * count;
    double least = CLOSE_TO_JAMMING;
    *contact = -1;
    if (!s->friction || !count)
        return OUTCOME_DONE;
    double *columns = TAKE(s->arena, double, (size_t)rows * s->n), *W = TAKE(s->arena, double, (size_t)rows *rows);
    const enum outcome outcome = s->arena->ran_out ? OUTCOME_NO_MEMORY : delassus(s, f->y, count, h->set, columns, W);
    for (int i = 0; i < count && !outcome; i++) {
        const double *row = W + (size_t)i * rows, resists = row[i];
        const double own = resists - against(h->mode[i]) * s->friction[h->set[i]] * row[count + i];
        if (against(h->mode[i]) && own <= least * resists) {
            *contact = h->set[i];
            least = own / resists;
        }
    }
    give_back(s->arena, mark);
    return outcome;
}
