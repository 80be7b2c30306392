/* Forces of held contacts that rigid bodies leave open, at any state of a smooth phase (docs/theory, section 5.10).
 *
 * The motion asks for some forces that give it, and what is held, and how, says which: friction that stays at its limit, contacts that are carried and have none. That is as
 * the loads were when it was decided. They change, and forces of least norm leave limits, or reach others, without a change of the motion, for which nothing has to
 * be decided anew. So these forces are found from those of the motion at each state that is asked for.
 *
 * A contact that slides has the friction that its sliding gives. One that stands has any within its limits, also if it is said to be at one of them. Of twins only the one that
 * bears has a force, what no motion moves has none, and what touches without pressing keeps what it has.
 */
#include "constraints/shared_forces.h"

#include <math.h>
#include <string.h>

#include "base/tolerances.h"
#include "constraints/delassus.h"
#include "constraints/mobility.h"
#include "constraints/twins.h"
#include "model/contacts.h"

/* The contacts among which forces are shared */
struct sharing {
    int count;
    int *set;                     /* [count] which */
    signed char *side;            /* [count] as of struct shared */
    char *moves;                  /* [count] scratch */
    char *leaves;                 /* [count] zeros: none opens */
    double *mu;                   /* [count] */
    double *P, *W;                /* [2 count], [2 count][2 count] */
    double *slips, *rates, *bias; /* [contacts] scratch */
};

int may_be_shared(const struct system *s)
{
    const struct active_set *h = s->active;
    if (active_count(s) && h->open)
        return 1;
    for (int i = 0; i < active_count(s); i++)
        if (h->mode[i] == AT_LIMIT_FORWARD || h->mode[i] == AT_LIMIT_BACKWARD)
            return 1;
    for (int c = 0; active_count(s) && c < s->model->contacts; c++)
        if (h->closed[c] == CARRIED)
            return 1;
    return 0;
}

static int take_sharing(struct system *s, struct sharing *p)
{
    const size_t c = s->model->contacts, rows = 2 * c;
    struct arena *arena = s->arena;
    *p = (struct sharing){.set = TAKE(arena, int, c),
                          .side = TAKE_ZEROS(arena, signed char, c),
                          .moves = TAKE(arena, char, c),
                          .leaves = TAKE_ZEROS(arena, char, c),
                          .mu = TAKE_ZEROS(arena, double, c),
                          .P = TAKE(arena, double, rows),
                          .W = TAKE(arena, double, rows *rows),
                          .slips = TAKE(arena, double, c),
                          .rates = TAKE(arena, double, c),
                          .bias = TAKE(arena, double, c)};
    return arena->ran_out;
}

/* Whether a carried contact touches as one does that bears in its place, however that one slides or stands */
static int is_twin(struct system *s, const double *q, int contact)
{
    const struct active_set *h = s->active;
    for (int i = 0; i < h->count; i++)
        if (twins_at(s, q, contact, h->set[i]))
            return 1;
    return 0;
}

/* The way in which a carried contact slides, or begins to; 0 where it stands */
static signed char side_of_carried(const struct system *s, const struct sharing *p, int contact)
{
    const double slips = p->slips[contact], begins = p->rates[contact] + p->bias[contact];
    const double speed = s->length / s->time;
    if (fabs(slips) > STILL * speed)
        return slips > 0.0 ? 1 : -1;
    return (signed char)(fabs(begins) <= PRESSED * speed / s->time ? 0 : begins > 0.0 ? 1 : -1);
}

/* The contacts that push, then those that are carried, with how each slides */
static enum outcome gather(struct system *s, const double *q, const double *u, const double *u_dot, struct sharing *p)
{
    const struct active_set *h = s->active;
    const struct ccgen_model *m = s->model;
    for (int i = 0; i < h->count; i++)
        if (h->mode[i] != GRAZING) {
            p->side[p->count] =
                (signed char)(h->mode[i] == SLIP_FORWARD || h->mode[i] == SLIP_BACKWARD ? h->mode[i] : 0);
            p->set[p->count++] = h->set[i];
        }
    const int pushing = p->count;
    if (s->friction) {
        m->slips(s->k, q, u, p->slips);
        m->slips(s->k, q, u_dot, p->rates);
        m->slip_bias(s->k, q, u, p->bias);
    }
    for (int c = 0; c < m->contacts; c++)
        if (h->closed[c] == CARRIED && !is_twin(s, q, c)) {
            p->side[p->count] = s->friction ? side_of_carried(s, p, c) : 0;
            p->set[p->count++] = c;
        }
    const enum outcome outcome =
        m->drives ? movable_contacts(s, q, p->count, p->set, p->moves) : (memset(p->moves, 1, p->count), OUTCOME_DONE);
    int kept = 0;
    for (int i = 0; !outcome && i < p->count; i++)
        if (i < pushing || p->moves[i]) {
            p->set[kept] = p->set[i];
            p->mu[kept] = s->friction ? s->friction[p->set[i]] : 0.0;
            p->side[kept++] = p->side[i];
        }
    p->count = kept;
    return outcome;
}

enum outcome share_pushes(struct system *s, const double *q, const double *u, const double *u_dot, double beyond,
                          double *push)
{
    const int contacts = s->model->contacts;
    const struct mark mark = s->arena->top;
    struct sharing p;
    double *columns = TAKE(s->arena, double, 2 * (size_t)contacts * s->n);
    enum outcome outcome = take_sharing(s, &p) ? OUTCOME_NO_MEMORY : gather(s, q, u, u_dot, &p);
    const int n = p.count, rows = s->friction ? 2 * n : n;
    outcome = outcome ? outcome : delassus(s, q, n, p.set, columns, p.W);
    if (!outcome) {
        for (int i = 0; i < rows; i++)
            p.P[i] = i < n ? push[p.set[i]] / lever_of(s, p.set[i]) : push[contacts + p.set[i - n]];
        const struct shared problem = {.n = n,
                                       .rows = rows,
                                       .W = p.W,
                                       .mu = p.mu,
                                       .side = p.side,
                                       .leaves = p.leaves,
                                       .beyond = beyond,
                                       .arena = s->arena};
        outcome = share_forces(&problem, p.P);
    }
    for (int i = 0; !outcome && i < rows; i++)
        push[i < n ? p.set[i] : contacts + p.set[i - n]] = i < n ? p.P[i] * lever_of(s, p.set[i]) : p.P[i];
    give_back(s->arena, mark);
    return outcome;
}
