/* The hybrid automaton; see automaton.h. */
#include "hybrid/automaton.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "base/tolerances.h"
#include "hybrid/contact_transition.h"
#include "impact/impact.h"
#include "steps/flat_loop.h"
#include "steps/phase.h"
#include "model/contacts.h"

enum {
    REPEATS = 1000, /* impacts at one instant */
    RATTLE = 1000,  /* the same of events between which no closed contact moves */
    IDLE =
        10 /* events of a gap that neither take time nor lead to an impact, before its contact is said to be at rest */
};

/* What an impact of the contacts f->set is about */
struct blow {
    int count;
    double *e;             /* [contacts] restitution */
    double *P;             /* [2 contacts] impulses, normal ones and then those of friction */
    double *rates;         /* [contacts] scratch */
    double *du, *momentum; /* [n] scratch */
};

/* 0, or 1 when memory runs out */
static int take_blow(const struct system *s, struct blow *b)
{
    const size_t contacts = s->model->contacts;
    b->e = TAKE(s->arena, double, contacts);
    b->P = TAKE(s->arena, double, 2 * contacts);
    b->rates = TAKE(s->arena, double, contacts);
    b->du = TAKE(s->arena, double, s->n);
    b->momentum = TAKE(s->arena, double, s->n);
    return s->arena->ran_out;
}

/* Work (J) of the impulses of friction */
static double friction_work(const struct phase *f, const struct blow *b, const double *u_plus)
{
    const struct system *s = f->s;
    double *slips = b->rates, work = 0.0;
    for (int side = 0; s->friction && side < 2; side++) {
        s->model->slips(s->k, f->y, side ? u_plus : f->y + s->n, slips);
        for (int i = 0; i < b->count; i++)
            work += 0.5 * b->P[b->count + i] * slips[f->set[i]];
    }
    return work;
}

/* Energy (J) that the contacts take, at speeds f->rates before the impact */
static double contact_loss(const struct phase *f, const struct blow *b, const double *u_plus)
{
    double loss = 0.0, *after = b->rates;
    contact_rates(f->s, f->y, u_plus, after);
    for (int i = 0; i < b->count; i++)
        loss -= 0.5 * b->P[i] / lever_of(f->s, f->set[i]) * (f->rates[f->set[i]] + after[f->set[i]]);
    return loss - friction_work(f, b, u_plus);
}

/* The same where driven joints, which do not change their speeds, do work in an impact too: what the mechanism loses */
static double jump_loss(const struct phase *f, const struct blow *b, const double *u_plus)
{
    const struct system *s = f->s;
    const int n = s->n;
    double loss = 0.0;
    const double *u = f->y + n;
    for (int i = 0; i < n; i++)
        b->du[i] = u_plus[i] - u[i];
    s->model->momentum(s->k, f->y, b->du, b->momentum);
    for (int i = 0; i < n; i++)
        loss -= 0.5 * (u[i] + u_plus[i]) * b->momentum[i];
    return loss;
}

/* All impacts of one instant: those contacts that are closed and not opening are struck together; if a closed contact is
 * left approaching, another impact follows. `trigger` is the contact whose event led here, or -1. */
static enum outcome resolve_with(struct phase *f, int trigger, struct blow *b)
{
    const struct ccgen_model *m = f->s->model;
    struct run *run = f->run;
    const int n = f->s->n;
    for (int repeat = 0;; repeat++) {
        if (interrupted(f->s->interruption, 0))
            return OUTCOME_INTERRUPTED;
        int approaching = 0;
        b->count = 0;
        contact_gaps(f->s, f->y, f->gaps);
        contact_rates(f->s, f->y, f->y + n, f->rates);
        for (int c = 0; c < m->contacts; c++) {
            const double closed = gap_tolerance(f, c), still = rest_velocity(f, c);
            if ((f->gaps[c] <= closed || (c == trigger && !repeat)) && f->rates[c] <= still) {
                approaching |= f->rates[c] < -still || (c == trigger && !repeat && f->rates[c] < 0.0);
                b->e[b->count] = f->s->restitution[c];
                f->set[b->count++] = c;
            }
        }
        if (!approaching)
            break;
        if (repeat == REPEATS)
            return OUTCOME_REPEATS;
        activate(f->s->active, 0, NULL, NULL); /* what was held may leave now */
        double *u_plus = f->y1 + n;
        enum outcome outcome = impact(f->s, f->y, f->y + n, b->count, f->set, b->e, u_plus, b->P);
        if (outcome) {
            run->contact = f->set[0];
            return outcome;
        }
        const double loss = m->drives ? jump_loss(f, b, u_plus) : contact_loss(f, b, u_plus);
        if (record_state(f) ||
            append_impact(&run->impacts, f->t, f->y + n, u_plus, n, b->count, f->set, b->P, loss, run->record.count))
            return OUTCOME_NO_MEMORY;
        memcpy(f->y + n, u_plus, n * sizeof *u_plus);
        if (record_state(f))
            return OUTCOME_NO_MEMORY;
    }
    return OUTCOME_DONE;
}

static enum outcome resolve_impacts(struct phase *f, int trigger)
{
    const struct mark mark = f->s->arena->top;
    struct blow blow;
    const enum outcome outcome = take_blow(f->s, &blow) ? OUTCOME_NO_MEMORY : resolve_with(f, trigger, &blow);
    give_back(f->s->arena, mark);
    return outcome;
}

/* Whether the closed contacts have moved since an event `since` ago by less than positions can show */
static int chatters(struct phase *f, double since)
{
    const struct ccgen_model *m = f->s->model;
    contact_gaps(f->s, f->y, f->gaps);
    contact_rates(f->s, f->y, f->y + f->s->n, f->rates);
    for (int c = 0; c < m->contacts; c++)
        if (f->gaps[c] <= gap_tolerance(f, c) && fabs(f->rates[c]) * since > UNSEEN * DBL_EPSILON * f->s->extent[c])
            return 0;
    return 1;
}

/* Count an event, and whether events still take time; put links that have come into a line there. */
static enum outcome meet(struct automaton *a, struct phase *f)
{
    const struct mode_change none = {-1, DETACHES};
    const double now = f->t - INSTANT * fmax(f->s->time, fabs(f->t)), since = f->at.since;
    a->still = chatters(f, f->t - since) ? a->still + 1 : 0;
    a->crowds = a->still >= RATTLE || (a->events >= CROWD && now <= a->last[(a->events - CROWD) % (2 * CROWD)]);
    if (a->events >= 2 * CROWD && now <= a->last[a->events % (2 * CROWD)]) {
        f->run->contact = a->event.contact;
        return OUTCOME_ACCUMULATION;
    }
    a->last[a->events++ % (2 * CROWD)] = f->t;
    f->run->events++;
    a->loss = a->event.watch >= 0 ? mode_change_of(f->s, a->event.watch) : none;
    int closed;
    return a->event.watch == FLAT ? OUTCOME_DONE : snap_to_singularity(f, 0, &closed);
}

static enum outcome move(struct automaton *a, struct phase *f)
{
    return integrate_to_event(f, &a->event);
}

static enum outcome strike(struct automaton *a, struct phase *f)
{
    const size_t impacts = f->run->impacts.count;
    const enum outcome outcome = resolve_impacts(f, a->event.watch == CLOSES ? a->event.contact : -1);
    a->struck = f->run->impacts.count > impacts;
    return outcome;
}

static enum outcome select_held(struct automaton *a, struct phase *f)
{
    const struct mode_change none = {-1, DETACHES};
    const int idle = !a->struck && a->event.watch == CLOSES && f->t == f->at.since;
    a->idle = idle ? a->idle + 1 : 0;
    return select_active_set(
        f, a->struck ? none : a->loss, /* what was lost is asked anew where an impact has changed it */
        a->crowds         ? ALL_REST
        : a->idle >= IDLE ? a->event.contact
                          : NONE_RESTS);
}

static int has_contacts(const struct automaton *a, const struct phase *f)
{
    (void)a;
    return f->s->model->contacts > 0;
}

static int meets_event(const struct automaton *a, const struct phase *f)
{
    (void)f;
    return a->event.contact >= 0;
}

static int time_is_left(const struct automaton *a, const struct phase *f)
{
    (void)a;
    return f->t < f->run->until;
}

/* What each stage does */
static enum outcome (*const ACTIONS[STAGES_OF_RUN])(struct automaton *a, struct phase *f) = {
    [MOVE] = move, [MEET] = meet, [STRIKE] = strike, [SELECT] = select_held};

/* and where it leads: to the first of its rows whose guard holds, if there is one. Where an action fails the run stops.
 * docs/events.md has a picture of it. */
static const struct {
    enum stage from;
    int (*guard)(const struct automaton *a, const struct phase *f);
    enum stage to;
} TRANSITIONS[] = {
    /* clang-format off */
    {START, has_contacts, STRIKE},
    {START, time_is_left, MOVE},
    {START, NULL, END},
    {STRIKE, NULL, SELECT},
    {SELECT, time_is_left, MOVE},
    {SELECT, NULL, END},
    {MOVE, meets_event, MEET},
    {MOVE, NULL, END},
    {MEET, NULL, STRIKE},
    {END, time_is_left, MOVE},
    {END, NULL, END},
    /* clang-format on */
};

void start_automaton(struct automaton *a)
{
    memset(a, 0, sizeof *a);
    a->stage = START;
    a->event = (struct event){-1, 0.0, LOST, 1.0};
    a->loss = (struct mode_change){-1, DETACHES};
}

enum outcome run_stage(struct automaton *a, struct phase *f)
{
    const enum outcome outcome = ACTIONS[a->stage] ? ACTIONS[a->stage](a, f) : OUTCOME_DONE;
    if (outcome)
        return outcome;
    if (a->stage != MOVE && interrupted(f->s->interruption, 0)) /* what was found without accelerations is none */
        return OUTCOME_INTERRUPTED;
    size_t row = 0;
    while (TRANSITIONS[row].from != a->stage || (TRANSITIONS[row].guard && !TRANSITIONS[row].guard(a, f)))
        row++;
    a->stage = TRANSITIONS[row].to;
    return OUTCOME_DONE;
}
