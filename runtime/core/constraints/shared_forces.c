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

/* Whether the forces P of the rows row[n] of contacts, and where there is friction of n rows of their sliding, pull or pass Coulomb's limits */
static int passes_law(const struct shared *c, const double *P)
{
    int passes = 0;
    for (int i = 0; i < c->n; i++)
        passes |= P[i] < 0.0 || (c->rows > c->n && !c->side[i] && fabs(P[c->n + i]) > c->mu[i] * P[i]);
    return passes;
}

/* Share the forces of the contacts which[n] of p, which hang together */
static enum outcome share_block(struct system *s, struct sharing *p, int n, const int *which, double beyond, char *kept)
{
    struct arena *arena = s->arena;
    const struct mark mark = arena->top;
    const int all = s->friction ? 2 * p->count : p->count, rows = s->friction ? 2 * n : n;
    double *W = TAKE(arena, double, (size_t)rows *rows), *P = TAKE(arena, double, rows), *mu = TAKE(arena, double, n);
    signed char *side = TAKE(arena, signed char, n);
    char *leaves = TAKE_ZEROS(arena, char, n);
    int *row = TAKE(arena, int, rows);
    enum outcome outcome = OUTCOME_NO_MEMORY;
    if (arena->ran_out)
        goto end;
    for (int i = 0; i < rows; i++)
        row[i] = i < n ? which[i] : p->count + which[i - n];
    for (int i = 0; i < n; i++) {
        mu[i] = p->mu[which[i]];
        side[i] = p->side[which[i]];
    }
    for (int i = 0; i < rows; i++) {
        P[i] = p->P[row[i]];
        for (int j = 0; j < rows; j++)
            W[i * rows + j] = p->W[(size_t)row[i] * all + row[j]];
    }
    const struct shared problem = {
        .n = n, .rows = rows, .W = W, .mu = mu, .side = side, .leaves = leaves, .beyond = beyond, .arena = arena};
    const int alone = kept && !passes_law(&problem, P); /* there is no need of others */
    outcome = alone ? OUTCOME_DONE : share_forces(&problem, P);
    for (int i = 0; i < rows && !outcome; i++)
        p->P[row[i]] = P[i];
    for (int i = 0; i < n && kept && !alone && !outcome; i++)
        kept[p->set[which[i]]] = 1;
end:
    give_back(arena, mark);
    return outcome;
}

/* The same block by block. Contacts of blocks that others keep are `kept`, where that is asked for; a block that has no others is no failure then. */
static enum outcome share_blocks(struct system *s, struct sharing *p, double beyond, char *kept)
{
    struct arena *arena = s->arena;
    const struct mark mark = arena->top;
    const int all = s->friction ? 2 * p->count : p->count;
    char *holds = TAKE(arena, char, all), *taken = TAKE_ZEROS(arena, char, all);
    int *row = TAKE(arena, int, all), *which = TAKE(arena, int, p->count);
    enum outcome outcome = arena->ran_out ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    for (int i = 0; i < all && !outcome; i++)
        holds[i] = 1;
    for (int i = 0; i < p->count && !outcome; i++) {
        if (taken[i])
            continue;
        const int size = rows_that_move_each_other(p->count, all, holds, p->W, i, taken, row);
        int n = 0;
        for (int k = 0; k < size; k++)
            if (row[k] < p->count)
                which[n++] = row[k];
        outcome = share_block(s, p, n, which, beyond, kept);
        if (kept && outcome == OUTCOME_REPEATS)
            outcome = OUTCOME_DONE;
    }
    give_back(arena, mark);
    return outcome;
}

enum outcome share_pushes(struct system *s, const double *q, const double *u, const double *u_dot, double beyond,
                          double *push, char *kept)
{
    const int contacts = s->model->contacts;
    const struct mark mark = s->arena->top;
    struct sharing p;
    double *columns = TAKE(s->arena, double, 2 * (size_t)contacts * s->n);
    enum outcome outcome = take_sharing(s, &p) ? OUTCOME_NO_MEMORY : gather(s, q, u, u_dot, &p);
    const int n = p.count, rows = s->friction ? 2 * n : n;
    outcome = outcome ? outcome : delassus(s, q, n, p.set, columns, p.W);
    for (int i = 0; i < rows && !outcome; i++)
        p.P[i] = i < n ? push[p.set[i]] / lever_of(s, p.set[i]) : push[contacts + p.set[i - n]];
    outcome = outcome ? outcome : share_blocks(s, &p, beyond, kept);
    for (int i = 0; !outcome && i < rows; i++)
        push[i < n ? p.set[i] : contacts + p.set[i - n]] = i < n ? p.P[i] * lever_of(s, p.set[i]) : p.P[i];
    give_back(s->arena, mark);
    return outcome;
}
