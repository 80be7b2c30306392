/* What contacts do to a motion (docs/theory, section 5.10).
 *
 * The motion with held contacts is the one that is integrated, by the same solver (contact_forces.c, or nullspace.c where forces
 * depend on each other). That solver leaves the multipliers as they are without contacts where it can; what forces P of
 * contacts add to them is what impulses N^T P add to impulses of the closure.
 */
#include "interface/forces.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "constraints/impulse.h"
#include "constraints/nullspace.h"
#include "hybrid/contact_transition.h"
#include "motion/acceleration.h"

static const double BEHIND = 1e-8; /* times extent: a gap further behind the surface is no rounding */

struct room {
    struct active_set active;
    struct phase phase;
    double *numbers;     /* all of the room */
    double *jump, *gaps; /* [n], [contacts] scratch */
    double *lambda;      /* [rows + 2 contacts] */
    double *more;        /* [joints][3] scratch */
    int *set;
};

static void free_room(struct system *s, struct room *r)
{
    free_active_set(&r->active);
    free(r->numbers);
    free(r->set);
    s->active = NULL;
}

static int make_room(struct system *s, struct room *r)
{
    const size_t c = s->model->contacts, size = s->size, search = search_scratch(s);
    memset(r, 0, sizeof *r);
    r->phase.s = s;
    r->numbers =
        calloc(2 * size + 4 * c + search + s->n + s->model->rows + 3 * s->model->joints + 1, sizeof *r->numbers);
    r->set = malloc((c + 1) * sizeof *r->set);
    if (make_active_set(&r->active, s->model) || !r->numbers || !r->set)
        return 1;
    s->active = c ? &r->active : NULL;
    r->phase.y = r->numbers;
    r->phase.dy = r->phase.y + size;
    r->phase.rates = r->phase.dy + size;
    r->phase.gaps = r->gaps = r->phase.rates + c;
    r->phase.search = r->gaps + c;
    r->jump = r->phase.search + search;
    r->lambda = r->jump + s->n;
    r->more = r->lambda + s->model->rows + 2 * c;
    r->phase.set = r->set;
    return 0;
}

/* Whether a contact is closed at q; gaps[contacts] */
static int touches(const struct system *s, const double *q, double *gaps)
{
    int found = 0;
    s->model->gaps(s->k, q, gaps);
    for (int c = 0; c < s->model->contacts; c++)
        found |= gaps[c] <= SHUT * s->extent[c];
    return found;
}

enum outcome find_closed(const struct system *s, size_t count, const double *q, char *closed)
{
    double *gaps = malloc((s->model->contacts + 1) * sizeof *gaps);
    for (size_t i = 0; i < count && gaps; i++)
        closed[i] = s->model->contacts && touches(s, q + i * s->n, gaps);
    free(gaps);
    return gaps ? OUTCOME_DONE : OUTCOME_NO_MEMORY;
}

/* Hold what the runtime would hold at the state, which is not moved. */
static enum outcome hold_asked(struct room *r, double t, const double *q, const double *u, struct obstruction *found)
{
    struct phase *f = &r->phase;
    struct system *s = f->s;
    activate(s->active, 0, NULL, NULL);
    memset(s->active->peak, 0, s->model->contacts * sizeof *s->active->peak); /* each state stands for itself */
    if (!touches(s, q, r->gaps))
        return OUTCOME_DONE;
    for (int c = 0; c < s->model->contacts; c++)
        if (r->gaps[c] < -BEHIND * s->extent[c] && (found->why == OBSTACLE_NONE || -r->gaps[c] > found->size)) {
            found->why = OBSTACLE_BEHIND;
            found->contact = c;
            found->size = -r->gaps[c];
        }
    if (found->why)
        return OUTCOME_DONE;
    f->t = t;
    memcpy(f->y, q, s->n * sizeof *q);
    memcpy(f->y + s->n, u, s->n * sizeof *u);
    const enum outcome outcome = would_activate(f, &found->contact);
    if (!outcome && found->contact >= 0) {
        found->why = OBSTACLE_STRIKES;
        found->size = -f->rates[found->contact];
    }
    return outcome;
}

static void hold_given(struct active_set *h, struct held held)
{
    activate(h, held.count, held.set, held.mode);
    for (int row = h->count; row < h->rows; row++)
        h->weight[row] = held.weight[h->of[row]];
}

/* push[2 contacts] from the forces of the rows */
static void pushes_of(const struct system *s, double *push)
{
    const struct active_set *h = s->active;
    double *friction = push + s->model->contacts;
    for (int i = 0, row = h->count; i < h->count; i++) {
        const int contact = h->set[i];
        push[contact] = h->force[i];
        if (h->mode[i] == STICK)
            friction[contact] = h->force[row++];
        else if (against(h->mode[i]))
            friction[contact] = -against(h->mode[i]) * s->friction[contact] * h->force[i];
    }
}

/* Generalized forces f[n] of push[2 contacts] */
static void generalized(struct system *s, const double *q, const double *push, double *f)
{
    const struct ccgen_model *m = s->model;
    m->contact_impulse(s->k, q, push, f);
    if (!m->slip_impulse)
        return;
    m->slip_impulse(s->k, q, push + m->contacts, s->jump);
    for (int i = 0; i < s->n; i++)
        f[i] += s->jump[i];
}

/* The motion with the contacts that are held */
static enum outcome motion(struct room *r, double t, const double *q, const double *u, double *u_dot, double *push)
{
    struct system *s = r->phase.s;
    const struct ccgen_model *m = s->model;
    const long dependent = s->rank_deficient;
    memset(push, 0, 2 * m->contacts * sizeof *push);
    const enum outcome outcome = system_acceleration(s, t, q, u, u_dot, r->lambda);
    if (outcome || !active_count(s))
        return outcome;
    pushes_of(s, push);
    if (s->rank_deficient > dependent) /* solved for together */
        return OUTCOME_DONE;
    generalized(s, q, push, s->active->f);
    memset(s->bias, 0, m->rows * sizeof *s->bias);
    if (m->impulse(s->k, q, s->active->f, s->bias, r->jump, s->multipliers))
        return OUTCOME_NOT_FINITE;
    for (int i = 0; i < m->rows; i++)
        r->lambda[i] += s->multipliers[i];
    return OUTCOME_DONE;
}

/* What the joints carry then: reaction[joints][3] */
static void react(struct room *r, double t, const double *q, const double *u, const double *u_dot, const double *push,
                  double *reaction)
{
    const struct system *s = r->phase.s;
    const struct ccgen_model *m = s->model;
    m->reactions(s->k, q, u, t, s->inputs, u_dot, r->lambda, reaction);
    if (!active_count(s))
        return;
    m->contact_reactions(s->k, q, push, r->more);
    for (int i = 0; i < 3 * m->joints; i++)
        reaction[i] += r->more[i];
}

enum outcome held_forces(struct system *s, size_t count, size_t every, const double *t, const double *q,
                         const double *u, struct held held, double *u_dot, double *lambda, double *push,
                         double *reaction, struct obstruction *found)
{
    const size_t n = s->n, rows = s->model->rows, c = s->model->contacts, entries = 3 * s->model->joints;
    struct room r;
    enum outcome outcome = OUTCOME_NO_MEMORY;
    *found = (struct obstruction){0, -1, OBSTACLE_NONE, 0.0};
    if (make_room(s, &r))
        goto end;
    outcome = OUTCOME_DONE;
    if (held.count >= 0 && c)
        hold_given(&r.active, held);
    for (size_t i = 0; i < count && !outcome && !found->why; i++) {
        const double *at = q + i * n, *moving = u + i * n, now = t[i * every];
        found->state = i;
        if (held.count < 0 && c && ((outcome = hold_asked(&r, now, at, moving, found)) || found->why))
            break;
        outcome = motion(&r, now, at, moving, u_dot + i * n, push + i * 2 * c);
        memcpy(lambda + i * (rows + 1), r.lambda, rows * sizeof *lambda);
        if (!outcome)
            react(&r, now, at, moving, u_dot + i * n, push + i * 2 * c, reaction + i * entries);
    }
end:
    free_room(s, &r);
    return outcome;
}

enum outcome joint_impulses(struct system *s, const double *q, const double *du, const double *P, double *reaction)
{
    const struct ccgen_model *m = s->model;
    const int entries = 3 * m->joints;
    double *f = malloc((2 * s->n + m->rows + entries + 1) * sizeof *f);
    if (!f)
        return OUTCOME_NO_MEMORY;
    double *jump = f + s->n, *rates = jump + s->n, *more = rates + m->rows;
    generalized(s, q, P, f);
    m->closure_rate(s->k, q, du, rates);
    const enum outcome outcome = system_impulse(s, q, f, rates, RANK_TOLERANCE, jump, s->multipliers);
    if (!outcome) {
        m->impulse_reactions(s->k, q, du, s->multipliers, reaction);
        m->contact_reactions(s->k, q, P, more);
        for (int i = 0; i < entries; i++)
            reaction[i] += more[i];
    }
    free(f);
    return outcome;
}

const char *obstacle_name(int obstacle)
{
#define NAMED(name, text) text,
    static const char *const names[] = {ALL_OBSTACLES(NAMED)};
#undef NAMED
    return obstacle >= 0 && obstacle < OBSTACLES ? names[obstacle] : NULL;
}
