/* What contacts do to a motion (docs/theory, section 5.10).
 *
 * The motion with held contacts is the one that is integrated, by the same solver (contact_forces.c, or nullspace.c where forces
 * depend on each other). That solver leaves the multipliers as they are without contacts where it can; what forces P of
 * contacts add to them is what impulses N^T P add to impulses of the closure.
 */
#include "interface/forces.h"

#include <math.h>
#include <string.h>

#include "base/tolerances.h"
#include "constraints/impulse.h"
#include "constraints/nullspace.h"
#include "constraints/shared_forces.h"
#include "hybrid/contact_transition.h"
#include "interface/limits.h"
#include "motion/acceleration.h"
#include "model/contacts.h"
#include "model/inputs.h"
#include "model/second_links.h"

struct room {
    struct active_set active;
    struct phase phase;
    struct run run;    /* none: what a decision says of it */
    signed char *mode; /* [contacts] scratch */
    double *f, *du;    /* [n] scratch */
    double *gaps;      /* [contacts] scratch */
    double *lambda;    /* [rows] */
    double *impulses;  /* [rows] scratch */
    double *still;     /* [rows] zeros */
    double *before;    /* [2 contacts] scratch */
    double *more;      /* [joints][3] scratch */
};

static int take_room(struct system *s, struct room *r)
{
    const struct ccgen_model *m = s->model;
    const size_t c = m->contacts, size = s->size;
    struct arena *arena = s->arena;
    *r = (struct room){
        .phase = {.s = s,
                  .y = TAKE_ZEROS(arena, double, size),
                  .dy = TAKE_ZEROS(arena, double, size),
                  .rates = TAKE_ZEROS(arena, double, c),
                  .gaps = TAKE_ZEROS(arena, double, c),
                  .set = TAKE(arena, int, c)},
        .mode = TAKE(arena, signed char, c),
        .f = TAKE(arena, double, s->n),
        .du = TAKE(arena, double, s->n),
        .gaps = TAKE(arena, double, c),
        .lambda = TAKE(arena, double, m->rows),
        .impulses = TAKE(arena, double, m->rows),
        .still = TAKE_ZEROS(arena, double, m->rows),
        .before = TAKE(arena, double, 2 * c),
        .more = TAKE(arena, double, 3 * (size_t)m->joints),
    };
    r->phase.run = &r->run;
    if (take_active_set(arena, &r->active, m))
        return 1;
    s->active = c ? &r->active : NULL;
    return 0;
}

/* Whether a contact of the gap is closed */
static int is_closed(const struct system *s, int contact, double gap)
{
    return gap <= SHUT * s->extent[contact];
}

/* Whether any contact is closed at q; gaps[contacts] */
static int touches(const struct system *s, const double *q, double *gaps)
{
    int found = 0;
    contact_gaps(s, q, gaps);
    for (int c = 0; c < s->model->contacts; c++)
        found |= is_closed(s, c, gaps[c]);
    return found;
}

enum outcome find_closed(const struct system *s, size_t count, const double *q, char *closed)
{
    const struct mark mark = s->arena->top;
    const int contacts = s->model->contacts;
    double *gaps = TAKE(s->arena, double, contacts);
    const enum outcome outcome = s->arena->ran_out ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    for (size_t i = 0; i < count && contacts && !outcome; i++) {
        contact_gaps(s, q + i * s->n, gaps);
        for (int c = 0; c < contacts; c++)
            closed[i * contacts + c] = (char)is_closed(s, c, gaps[c]);
    }
    give_back(s->arena, mark);
    return outcome;
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
    if (found->why) {
        found->size /= lever_of(s, found->contact);
        return OUTCOME_DONE;
    }
    f->t = t;
    memcpy(f->y, q, s->n * sizeof *q);
    memcpy(f->y + s->n, u, s->n * sizeof *u);
    const enum outcome outcome = would_activate(f, &found->contact);
    if (!outcome && found->contact >= 0) {
        found->why = OBSTACLE_STRIKES;
        found->size = -f->rates[found->contact] / lever_of(s, found->contact);
    }
    return outcome;
}

/* push[2 contacts] from the forces of the rows */
static void pushes_of(const struct system *s, double *push)
{
    const struct active_set *h = s->active;
    double *friction = push + s->model->contacts;
    for (int i = 0, row = h->count; i < h->count; i++) {
        const int contact = h->set[i];
        push[contact] = h->force[i] * lever_of(s, contact);
        if (h->mode[i] == STICK)
            friction[contact] = h->force[row++];
        else if (against(h->mode[i]))
            friction[contact] = -against(h->mode[i]) * s->friction[contact] * h->force[i];
    }
}

/* Generalized forces f[n] of push[2 contacts]; friction[n] is scratch. */
static void generalized(const struct system *s, const double *q, const double *push, double *friction, double *f)
{
    const struct ccgen_model *m = s->model;
    m->contact_impulse(s->k, q, push, f);
    if (!m->slip_impulse)
        return;
    m->slip_impulse(s->k, q, push + m->contacts, friction);
    for (int i = 0; i < s->n; i++)
        f[i] += friction[i];
}

/* Hold what is given. Those that are carried push where forces are shared, else not. */
static void hold_given(struct active_set *h, const struct ccgen_model *m, struct held held, int *set, signed char *mode)
{
    int count = 0;
    clear_active_set(h, m);
    for (int i = 0; i < held.count; i++) {
        h->closed[held.set[i]] = held.mode[i] == IMPLIED ? CARRIED : PUSHING;
        if (held.mode[i] != IMPLIED) {
            set[count] = held.set[i];
            mode[count++] = held.mode[i];
        }
    }
    activate(h, count, set, mode);
}

/* push[2 contacts] <- the forces of least norm that move nothing otherwise, and what they do to the multipliers */
static enum outcome share(struct room *r, const double *q, const double *u, const double *u_dot, double *push)
{
    struct system *s = r->phase.s;
    const struct ccgen_model *m = s->model;
    const int pushes = 2 * m->contacts;
    memcpy(r->before, push, pushes * sizeof *push);
    const double beyond[] = {0.0, PASSES_LAW, AS_GIVEN}; /* what is within the law before what is not */
    enum outcome outcome = OUTCOME_REPEATS;
    for (int i = 0; i < 3 && outcome == OUTCOME_REPEATS; i++)
        outcome = share_pushes(s, q, u, u_dot, beyond[i], push, NULL);
    if (outcome || !s->rows_on)
        return outcome;
    for (int c = 0; c < pushes; c++)
        r->before[c] = push[c] - r->before[c];
    generalized(s, q, r->before, r->du, r->f);
    outcome = system_impulse(s, q, r->f, r->still, RANK_TOLERANCE, r->du, r->impulses);
    for (int i = 0; i < m->rows && !outcome; i++)
        r->lambda[i] += r->impulses[i];
    return outcome;
}

/* The motion with the contacts that are held */
static enum outcome motion(struct room *r, double t, const double *q, const double *u, int shared, double *u_dot,
                           double *push)
{
    struct system *s = r->phase.s;
    const struct ccgen_model *m = s->model;
    const long dependent = s->rank_deficient;
    memset(push, 0, 2 * m->contacts * sizeof *push);
    const enum outcome outcome = system_acceleration(s, t, q, u, u_dot, r->lambda);
    if (outcome || !active_count(s))
        return outcome;
    pushes_of(s, push);
    if (s->rank_deficient == dependent) { /* else solved for together */
        generalized(s, q, push, r->du, r->f);
        if (m->impulse(s->k, q, r->f, r->still, r->du, r->impulses))
            return OUTCOME_NOT_FINITE;
        for (int i = 0; i < m->rows; i++)
            r->lambda[i] += r->impulses[i];
    }
    return shared && may_be_shared(s) ? share(r, q, u, u_dot, push) : OUTCOME_DONE;
}

/* Whether closure rows are so near to dependence at q that no acceleration is known, and no force; where they are dependent to rounding they are known
 * again, as those of least norm */
static int is_unknown(struct system *s, const double *q)
{
    double sigma;
    return row_rank(s, q, &sigma) == s->rows_on + s->model->drives && sigma < NO_ACCELERATION;
}

/* What the joints do to their second links then: reaction[joints][3] */
static void react(struct room *r, double t, const double *q, const double *u, const double *u_dot, const double *push,
                  double *reaction)
{
    const struct system *s = r->phase.s;
    const struct ccgen_model *m = s->model;
    m->reactions(s->k, q, u, t, s->inputs, u_dot, r->lambda, reaction);
    if (active_count(s)) {
        m->contact_reactions(s->k, q, push, r->more);
        for (int i = 0; i < 3 * m->joints; i++)
            reaction[i] += r->more[i];
    }
    turn_to_second_links(m, 1, 1, reaction);
}

/* What is told of a state, in one block: u_dot[n], lambda[rows], push[2 contacts], reaction[joints][3], told[told] */
enum { ACCELERATION, MULTIPLIER, PUSH, REACTION, TOLD, GROUPS };

struct asked {
    struct room *r;
    double t;
    int shared;
    struct group groups[GROUPS];
};

static void prepare(const struct system *s, struct room *r, int shared, struct asked *a)
{
    const struct ccgen_model *m = s->model;
    const double acceleration = 1.0 / (s->time * s->time), force = s->energy / s->length; /* lengths in units */
    *a = (struct asked){.r = r,
                        .shared = shared,
                        .groups = {[ACCELERATION] = {s->n, 0, acceleration},
                                   [MULTIPLIER] = {m->rows, 1, force},
                                   [PUSH] = {2 * m->contacts, 0, force},
                                   [REACTION] = {3 * m->joints, 1, force},
                                   [TOLD] = {m->told, 0, 0.0}}};
}

static double *part_of(const struct asked *a, int group, double *block)
{
    for (int g = 0; g < group; g++)
        block += a->groups[g].count;
    return block;
}

/* An `evaluation`, with the contacts that are held */
static enum outcome evaluate(void *context, const double *q, const double *u, double *block)
{
    const struct asked *a = context;
    struct room *r = a->r;
    const struct system *s = r->phase.s;
    double *u_dot = part_of(a, ACCELERATION, block), *push = part_of(a, PUSH, block);
    const enum outcome outcome = motion(r, a->t, q, u, a->shared, u_dot, push);
    memcpy(part_of(a, MULTIPLIER, block), r->lambda, s->model->rows * sizeof *block);
    if (outcome)
        return outcome;
    react(r, a->t, q, u, u_dot, push, part_of(a, REACTION, block));
    if (s->model->told) /* as `react`, under the inputs that the acceleration has asked for */
        s->model->outputs(s->k, q, u, a->t, s->inputs, part_of(a, TOLD, block));
    return OUTCOME_DONE;
}

/* The same, or the limit where rows are dependent; *rank is how many count elsewhere, once that is known. *unknown is whether nothing is known there. */
static enum outcome evaluate_or_limit(struct asked *a, const double *q, const double *u, int *rank, char *unknown,
                                      double *block)
{
    struct system *s = a->r->phase.s;
    int found = 0;
    *unknown = 0;
    if (near_a_limit(s, q, *rank)) {
        enum outcome outcome = supply_inputs(s, a->t, q, u);
        int (*const source)(void *, double, const double *, const double *, double *) = s->input_source;
        s->input_source = NULL; /* a controller is asked at the state alone: the limit is that under these inputs */
        outcome = outcome ? outcome : limit_along_branch(s, q, u, a->groups, GROUPS, evaluate, a, rank, &found, block);
        s->input_source = source;
        if (outcome || found)
            return outcome;
        *unknown = (char)is_unknown(s, q);
    }
    return evaluate(a, q, u, block);
}

enum outcome held_forces(struct system *s, size_t count, size_t every, const double *t, const double *q,
                         const double *u, const double *latched, struct held held, double *u_dot, double *lambda,
                         double *push, double *reaction, double *told, char *unknown, struct obstruction *found)
{
    const struct ccgen_model *m = s->model;
    const size_t n = s->n, c = m->contacts;
    const struct mark mark = s->arena->top;
    struct room r;
    struct asked a;
    enum outcome outcome = OUTCOME_NO_MEMORY;
    int rank = 0;
    *found = (struct obstruction){0, -1, OBSTACLE_NONE, 0.0};
    if (take_room(s, &r))
        goto end;
    prepare(s, &r, held.shared, &a);
    size_t size = 0;
    for (int g = 0; g < GROUPS; g++)
        size += a.groups[g].count;
    double *block = TAKE_ZEROS(s->arena, double, size);
    if (s->arena->ran_out)
        goto end;
    outcome = OUTCOME_DONE;
    if (held.count >= 0 && c)
        hold_given(&r.active, m, held, r.phase.set, r.mode);
    for (size_t i = 0; i < count && !outcome && !found->why; i++) {
        const double *at = q + i * n, *moving = u + i * n;
        a.t = t[i * every];
        found->state = i;
        s->latched = latched ? latched + i * m->latches : NULL;
        if (held.count < 0 && c && ((outcome = hold_asked(&r, a.t, at, moving, found)) || found->why))
            break;
        outcome =
            unknown ? evaluate_or_limit(&a, at, moving, &rank, &unknown[i], block) : evaluate(&a, at, moving, block);
        memcpy(u_dot + i * n, part_of(&a, ACCELERATION, block), n * sizeof *block);
        memcpy(lambda + i * (m->rows + 1), part_of(&a, MULTIPLIER, block), m->rows * sizeof *block);
        memcpy(push + i * 2 * c, part_of(&a, PUSH, block), 2 * c * sizeof *block);
        if (outcome)
            break;
        memcpy(reaction + i * 3 * m->joints, part_of(&a, REACTION, block), 3 * m->joints * sizeof *block);
        memcpy(told + i * m->told, part_of(&a, TOLD, block), m->told * sizeof *block);
    }
end:
    s->active = NULL;
    s->latched = NULL;
    give_back(s->arena, mark);
    return outcome;
}

enum outcome joint_impulses(struct system *s, const double *q, const double *du, const double *P, double *reaction)
{
    const struct ccgen_model *m = s->model;
    const int entries = 3 * m->joints;
    struct arena *arena = s->arena;
    const struct mark mark = arena->top;
    double *f = TAKE_ZEROS(arena, double, s->n), *jump = TAKE(arena, double, s->n);
    double *rates = TAKE(arena, double, m->rows), *impulses = TAKE(arena, double, m->rows);
    double *more = TAKE(arena, double, entries);
    enum outcome outcome = OUTCOME_NO_MEMORY;
    if (arena->ran_out)
        goto end;
    if (m->contacts)
        generalized(s, q, P, jump, f);
    m->closure_rate(s->k, q, du, rates);
    outcome = system_impulse(s, q, f, rates, RANK_TOLERANCE, jump, impulses);
    if (outcome)
        goto end;
    m->impulse_reactions(s->k, q, du, impulses, reaction);
    if (m->contacts)
        m->contact_reactions(s->k, q, P, more);
    for (int i = 0; i < entries && m->contacts; i++)
        reaction[i] += more[i];
    turn_to_second_links(m, 1, 1, reaction);
end:
    give_back(arena, mark);
    return outcome;
}

const char *obstacle_name(int obstacle)
{
#define NAMED(name, text) text,
    static const char *const names[] = {ALL_OBSTACLES(NAMED)};
#undef NAMED
    return obstacle >= 0 && obstacle < OBSTACLES ? names[obstacle] : NULL;
}
