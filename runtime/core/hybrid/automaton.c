/* The hybrid automaton; see automaton.h. */
#include "hybrid/automaton.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "base/tolerances.h"
#include "constraints/delassus.h"
#include "constraints/mobility.h"
#include "constraints/nullspace.h"
#include "hybrid/cone.h"
#include "hybrid/contact_transition.h"
#include "hybrid/immovable.h"
#include "hybrid/jam.h"
#include "hybrid/lying_flat.h"
#include "hybrid/own_impact.h"
#include "hybrid/striking.h"
#include "impact/impact.h"
#include "steps/pace.h"
#include "steps/phase.h"
#include "model/contacts.h"

static const struct event NO_EVENT = {-1, 0.0, LOST, 1.0};
static const struct mode_change NO_LOSS = {-1, DETACHES};

/* Whether the closed contacts have moved since an event `since` ago by less than positions can show. An event of a contact that slides, or begins to, is
 * no rattling: held contacts do not move at all. */
static int chatters(const struct automaton *a, struct phase *f, double since)
{
    const struct ccgen_model *m = f->s->model;
    if (a->event.watch >= 0 && mode_change_of(f->s, a->event.watch).how != DETACHES)
        return 0;
    contact_gaps(f->s, f->y, f->gaps);
    contact_rates(f->s, f->y, f->y + f->s->n, f->rates);
    for (int c = 0; c < m->contacts; c++)
        if (f->gaps[c] <= gap_tolerance(f, c) && fabs(f->rates[c]) * since > UNSEEN * DBL_EPSILON * f->s->extent[c])
            return 0;
    return 1;
}

/* Count, of each contact, the events in a row that left it no room: neither its gap nor what that has changed by since the last event can be told from zero. */
static void note_tight(struct phase *f, double since)
{
    contact_gaps(f->s, f->y, f->gaps);
    contact_rates(f->s, f->y, f->y + f->s->n, f->rates);
    for (int c = 0; c < f->s->model->contacts; c++) {
        const double none = SHUT * f->s->extent[c];
        f->tight[c] = f->gaps[c] <= none && fabs(f->rates[c]) * since <= none ? f->tight[c] + 1 : 0;
    }
}

void note_speed(struct automaton *a, struct phase *f)
{
    a->quick = fmax(a->quick, fastest(f->s, f->y + f->s->n) * f->s->time);
    f->at.seen = SEEN * fmin(1.0, a->quick);
}

/* Bring bounces to rest that are the slower the fewer events a window has had: where events become ever more, bounces are ever
 * smaller, and would never end. Only events of contacts
 * that have had more than ORDINARY themselves count: many bodies that each strike now and then are no crowd. A ball with e = 0.99 has come to bounces of 10^-12 of the height that it fell from in the last second, one with 0.999 to a
 * millionth, when a two-hundredth of the steps and events that a window may have are spent, which are 1000. The speed then doubles
 * with their number, up to SEEN of the fastest that anything has been in the window, and no further: what is faster is a motion, and goes on event by
 * event, or by time stepping where a window has too many. An event costs as the mechanism has coordinates: with more than a few it
 * may have fewer, in proportion, so that windows cost alike, but EACH for every contact that crowds: bounces of two thirds of the speed before have come
 * to 10^-11 of it by then. */
static void slow_down(struct automaton *a, struct phase *f)
{
    struct run *run = f->run;
    if (f->t >= a->window + window_of(f)) {
        a->window = f->t;
        a->earlier = a->events;
        a->crowd = 0;
        a->quick = 0.0;
        memset(f->met, 0, f->s->model->contacts * sizeof *f->met);
    }
    note_speed(a, f);
    if (a->event.watch != CLOSES) /* those that close are counted as they strike, with those that strike beside them */
        f->met[a->event.contact]++;
    a->crowd += f->met[a->event.contact] > (int)ORDINARY;
    long crowded = 0;
    for (int c = 0; c < f->s->model->contacts; c++)
        crowded += f->met[c] > (int)ORDINARY ? (long)EACH : 0;
    const long most = run->rate_budget / 200, n = f->s->n;
    const long share = n > (long)FEW ? most * (long)FEW / n : most, patience = share > crowded ? share : crowded;
    const long beyond = a->crowd - patience, each = patience / 32 + 1;
    f->at.slow = beyond <= 0 ? 0.0 : fmin(ldexp(CROWDED_SPEED, (int)fmin((double)(beyond / each), 64.0)), f->at.seen);
    if (f->at.slow > 0.0) /* contacts that move faster and rest for it note that themselves */
        run->rest_speed = fmax(run->rest_speed, REST_SPEED * f->s->length / f->s->time);
}

/* Count an event, and whether events still take time; and put down a loop that all but lies flat. */
static enum outcome meet(struct automaton *a, struct phase *f)
{
    note_tight(f, f->t - f->at.since);
    a->still = chatters(a, f, f->t - f->at.since) ? a->still + 1 : 0;
    if (f->t > a->instant + INSTANT * fmax(f->s->time, fabs(f->t))) {
        a->instant = f->t;
        a->at_once = 0;
    }
    a->at_once++;
    a->crowds = a->still >= (long)RATTLE || a->at_once > (long)CROWD;
    /* What strikes faster than what rests loses energy, or with e = 1 is ended by what a window may have; but drives give it back. */
    const int bounces = !f->s->model->drives && a->struck &&
                        (a->event.watch != CLOSES || f->rates[a->event.contact] < -rest_velocity(f, a->event.contact));
    if (a->at_once > 2 * (long)CROWD && !bounces) {
        f->run->contact = a->event.contact;
        return OUTCOME_ACCUMULATION;
    }
    a->events++;
    slow_down(a, f);
    f->run->events++;
    a->loss = a->event.watch >= 0 ? mode_change_of(f->s, a->event.watch) : NO_LOSS;
    int contact;
    const enum outcome outcome = lay_flat(f, &contact);
    if (contact >= 0)
        a->loss = NO_LOSS;
    return outcome;
}

static enum outcome move(struct automaton *a, struct phase *f)
{
    return integrate_to_event(f, &a->event);
}

static enum outcome strike(struct automaton *a, struct phase *f)
{
    enum outcome outcome = come_onto_branch(f);
    const size_t impacts = f->run->impacts.count;
    outcome = outcome ? outcome : resolve_impacts(f, a->event.watch == CLOSES ? a->event.contact : -1);
    f->s->branch = NULL;
    a->struck = f->run->impacts.count > impacts;
    if (a->struck && rank_margin(f->s, f->y) >= BRIDGED) /* forces behind it are others, and known by themselves */
        memset(f->s->active->peak, 0, f->s->model->contacts * sizeof *f->s->active->peak);
    return outcome || !a->struck ? outcome : leave_on_cone(f);
}

/* Record what the contact transition takes as an impact without impulses, where it stops bounces that are no rounding. */
static enum outcome note_stopped(struct phase *f, const double *u_before, double *P)
{
    struct system *s = f->s;
    const struct active_set *h = s->active;
    const double *u_after = f->y + s->n;
    const double loss =
        jump_loss(s, f->y, u_before, u_after, f->dy1, f->dy1 + s->n); /* as scratch: no step is under way */
    memset(P, 0, 2 * (size_t)s->model->contacts * sizeof *P);
    if (!h->count || !(s->model->drives ? loss != 0.0 : loss > 0.0)) /* drives may add */
        return OUTCOME_DONE;
    return append_impact(&f->run->impacts, f->t, u_before, u_after, s->n, h->count, h->set, P, loss, 1.0,
                         f->run->record.count - 1)
               ? OUTCOME_NO_MEMORY
               : OUTCOME_DONE;
}

static enum outcome select_slow(struct phase *f, struct mode_change loss, int resting)
{
    struct system *s = f->s;
    const struct mark mark = s->arena->top;
    double *u = TAKE(s->arena, double, s->n), *P = TAKE(s->arena, double, 2 * (size_t)s->model->contacts);
    enum outcome outcome = s->arena->ran_out || record_state(f) ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    if (!outcome) {
        memcpy(u, f->y + s->n, s->n * sizeof *u);
        outcome = select_active_set(f, loss, resting);
        outcome = outcome ? outcome : note_stopped(f, u, P);
    }
    give_back(s->arena, mark);
    return outcome;
}

/* What a stage that takes no time begins with, to which the run goes back where it turns out wrong */
struct before_stage {
    double *y;       /* [size] */
    double *latched; /* [latches] */
    double t;
    double energy[2]; /* J: kinetic, potential */
    struct active_set active;
    long steps, rejected, choices;
    double rest_speed;
    double *heading; /* [n] */
    size_t rows, impacts, struck, changes, closed, stretches;
    size_t last; /* row of the last stretch of time stepping, which may go on, */
    double t1, step, miss;
};

static enum outcome note_stage(const struct phase *f, struct before_stage *before)
{
    const struct system *s = f->s;
    const struct run *run = f->run;
    before->y = TAKE(s->arena, double, s->size);
    before->latched = TAKE(s->arena, double, s->model->latches);
    before->heading = TAKE(s->arena, double, s->n);
    if (take_active_set(s->arena, &before->active, s->model))
        return OUTCOME_NO_MEMORY;
    copy_active_set(&before->active, &f->active, s->model->contacts);
    memcpy(before->y, f->y, (size_t)s->size * sizeof *f->y);
    memcpy(before->heading, f->branch.heading, s->n * sizeof *before->heading);
    for (int l = 0; l < s->model->latches; l++)
        before->latched[l] = f->latched[l];
    s->model->energy(s->k, f->y, f->y + s->n, before->energy);
    before->t = f->t;
    before->steps = run->steps;
    before->rejected = run->rejected;
    before->choices = run->choices;
    before->rest_speed = run->rest_speed;
    before->rows = run->record.count;
    before->impacts = run->impacts.count;
    before->struck = run->impacts.contact_count;
    before->changes = run->modes.count;
    before->closed = run->modes.contact_count;
    before->stretches = run->stepping.count;
    if (before->stretches) {
        const size_t i = before->stretches - 1;
        before->last = run->stepping.last[i];
        before->t1 = run->stepping.t1[i];
        before->step = run->stepping.step[i];
        before->miss = run->stepping.miss[i];
    }
    return OUTCOME_DONE;
}

/* As if the stage had not been begun */
static void undo_stage(struct phase *f, const struct before_stage *before)
{
    const struct system *s = f->s;
    struct run *run = f->run;
    memcpy(f->y, before->y, (size_t)s->size * sizeof *f->y);
    memcpy(f->branch.heading, before->heading, s->n * sizeof *before->heading);
    copy_active_set(&f->active, &before->active, s->model->contacts);
    for (int l = 0; l < s->model->latches; l++)
        f->latched[l] = before->latched[l];
    f->t = before->t;
    run->steps = before->steps;
    run->rejected = before->rejected;
    run->choices = before->choices;
    run->rest_speed = before->rest_speed;
    run->record.count = before->rows;
    run->impacts.count = before->impacts;
    run->impacts.contact_count = before->struck;
    run->modes.count = before->changes;
    run->modes.contact_count = before->closed;
    run->stepping.count = before->stretches;
    if (before->stretches) {
        const size_t i = before->stretches - 1;
        run->stepping.last[i] = before->last;
        run->stepping.t1[i] = before->t1;
        run->stepping.step[i] = before->step;
        run->stepping.miss[i] = before->miss;
    }
}

/* Select what is held. Where that has no forces, as friction jams, it is asked once more with all at rest, along grounds too, that may come to rest in a crowd of events: what
 * slides that slowly is stopped by the jam, and time stepping, which would do it, has many contacts apart for a while. */
static enum outcome select_held(struct automaton *a, struct phase *f)
{
    const int idle = !a->struck && a->event.watch == CLOSES && f->t == f->at.since;
    a->idle = idle ? a->idle + 1 : 0;
    const struct mode_change loss = a->struck ? NO_LOSS : a->loss; /* asked anew where an impact has changed it */
    const int resting = a->crowds ? ALL_REST : a->idle >= (int)IDLE ? a->event.contact : NONE_RESTS;
    const double slow = f->at.slow;
    const struct mark mark = f->s->arena->top;
    struct before_stage before;
    enum outcome outcome = note_stage(f, &before);
    outcome = outcome ? outcome : (slow > 0.0 ? select_slow : select_active_set)(f, loss, resting);
    if (f->s->friction && slow < f->at.seen && (outcome == OUTCOME_JAMMED || outcome == OUTCOME_REPEATS)) {
        const int contact = f->run->contact;
        undo_stage(f, &before);
        f->at.slow = f->at.seen;
        const enum outcome again = select_slow(f, loss, resting);
        f->at.slow = slow;
        const int failed = again && again != OUTCOME_NO_MEMORY && again != OUTCOME_INTERRUPTED;
        if (failed)
            undo_stage(f, &before);
        f->run->contact = failed ? contact : -1;
        outcome = failed ? outcome : again;
    }
    give_back(f->s->arena, mark);
    return outcome;
}

/* Event by event again: nothing is known but the state, and that time stepping has led there. */
static void hand_over(struct automaton *a, struct phase *f)
{
    struct run *run = f->run;
    f->at = (struct progress){.seen = f->at.seen, .slow = f->at.slow, .widest = f->at.widest, .follows = f->at.follows};
    f->h = 0.0;
    memset(f->tight, 0, f->s->model->contacts * sizeof *f->tight);
    a->event = NO_EVENT;
    a->loss = NO_LOSS;
    a->crowds = a->struck = a->idle = 0;
    a->still = 0;
    a->instant = -INFINITY;
    a->at_once = 0;
    run->window = f->t;
    run->spent_before = run->steps + run->rejected + run->events;
}

static enum outcome step(struct automaton *a, struct phase *f)
{
    if (f->run->method->order == 0)
        return step_to_end(&a->span, f);
    const enum outcome outcome = step_through_span(&a->span, f);
    if (contacts_have_none(outcome)) { /* it is told why event by event did not get further */
        f->run->contact = a->at_fault;
        return a->failed;
    }
    if (outcome || a->span.under_way)
        return outcome;
    hand_over(a, f);
    return OUTCOME_DONE;
}

/* Whether time stepping may get further where a stage has failed so: what is unknown there is what contacts do. Beside
 * drives that is so of jams and crowds alone: where steps shrink there, links come into a line that the prescribed motion forces them through, with velocities
 * that have no bound, and steps of any kind would be far off. What the caller has chosen stays: to stop at what would gain, and steps of fixed length, but where no step of any
 * length would do. */
static int may_step(const struct automaton *a, const struct phase *f, enum outcome outcome)
{
    if (!f->s->model->contacts || a->stage == STEP || a->stage == START)
        return 0;
    switch (outcome) {
    case OUTCOME_JAMMED:
    case OUTCOME_REPEATS:
    case OUTCOME_ACCUMULATION:
        return 1;
    case OUTCOME_INEXACT: /* of contacts: steps may ask others */
        return a->stage != MOVE;
    case OUTCOME_GAINED:
        return f->run->on_gain == GAIN_REDUCES;
    case OUTCOME_CROWDED: /* by steps in flight is no matter of contacts, but where links all but lie in a line */
        return f->run->fixed_step == 0.0 && (a->events - a->earlier > f->run->rate_budget / 1000 || is_crawling(f));
    case OUTCOME_STEP_TOO_SMALL:
    case OUTCOME_NOT_CLOSED:
    case OUTCOME_ESCAPED:
    case OUTCOME_NO_CONVERGENCE:
        return f->run->fixed_step == 0.0 && !f->s->model->drives;
    default:
        return 0;
    }
}

static int steps_in_time(const struct automaton *a, const struct phase *f)
{
    (void)a;
    return f->run->method->order == 0;
}

static int span_is_left(const struct automaton *a, const struct phase *f)
{
    return f->t < f->run->until && (a->span.under_way || steps_in_time(a, f));
}

static int span_has_ended(const struct automaton *a, const struct phase *f)
{
    return !a->span.under_way && !steps_in_time(a, f);
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
    [MOVE] = move, [MEET] = meet, [STRIKE] = strike, [SELECT] = select_held, [STEP] = step};

/* and where it leads: to the first of its rows whose guard holds, if there is one. Where an action fails the run stops.
 * docs/events.md has a picture of it. */
static const struct {
    enum stage from;
    int (*guard)(const struct automaton *a, const struct phase *f);
    enum stage to;
} TRANSITIONS[] = {
    /* clang-format off */
    {START, steps_in_time, STEP},
    {START, has_contacts, STRIKE},
    {START, time_is_left, MOVE},
    {START, NULL, END},
    {STRIKE, NULL, SELECT},
    {SELECT, time_is_left, MOVE},
    {SELECT, NULL, END},
    {MOVE, meets_event, MEET},
    {MOVE, NULL, END},
    {MEET, NULL, STRIKE},
    {STEP, span_has_ended, STRIKE},
    {STEP, NULL, END},
    {END, span_is_left, STEP},
    {END, time_is_left, MOVE},
    {END, NULL, END},
    /* clang-format on */
};

void start_automaton(struct automaton *a)
{
    memset(a, 0, sizeof *a);
    a->stage = START;
    a->event = NO_EVENT;
    a->loss = NO_LOSS;
    a->jammed = NAN;
    a->instant = -INFINITY;
}

/* Whether a first step of time stepping gets on, which is taken back: where drives prescribe what contacts and loops do not let happen none does, and the run
 * stays as it has come there. Without drives there is one always. */
static enum outcome try_span(const struct automaton *a, struct phase *f)
{
    const struct mark mark = f->s->arena->top;
    struct span span = a->span;
    struct before_stage before;
    if (!f->s->model->drives)
        return OUTCOME_DONE;
    enum outcome outcome = note_stage(f, &before);
    if (!outcome) {
        outcome = begin_span(&span, f);
        span.ends = f->t + span.step;
        outcome = outcome ? outcome : step_through_span(&span, f);
        undo_stage(f, &before);
    }
    give_back(f->s->arena, mark);
    return outcome;
}

/* What is asked of f->set[count] where a stage has failed: their rows that may hold, and of which contacts. In an impact all friction may hold, and what approaches
 * is in it; else what slides goes on sliding, and the contact that is at fault is, if one is known. */
static void choose_rows(const struct automaton *a, struct phase *f, int count, double *slips, char *holds, char *asked)
{
    const struct system *s = f->s;
    const double *u = f->y + s->n, speed = fastest(s, u);
    const int strikes = a->stage == STRIKE, at_fault = f->run->contact;
    if (s->friction)
        s->model->slips(s->k, f->y, u, slips);
    for (int i = 0; i < count; i++) {
        const int c = f->set[i];
        const double extent = s->extent[c];
        holds[i] = 1;
        if (s->friction)
            holds[count + i] = s->friction[c] > 0.0 && (strikes || fabs(slips[c]) <= CREEP * extent / s->time);
        asked[i] = strikes ? f->rates[c] < -ROUNDED_RATE * speed * extent : at_fault == c;
    }
}

/* A contact of those that the stage has failed at, of which masses hide what they can do: neither events nor steps know their impulses then; or -1 */
static int find_hidden(const struct automaton *a, struct phase *f)
{
    struct system *s = f->s;
    const int contacts = s->model->contacts;
    const struct mark mark = s->arena->top;
    int count = 0, hidden = -1;
    contact_gaps(s, f->y, f->gaps);
    contact_rates(s, f->y, f->y + s->n, f->rates);
    for (int c = 0; c < contacts; c++)
        if (f->gaps[c] <= gap_tolerance(f, c))
            f->set[count++] = c;
    if (leave_out_immovable(f, f->y, &count, f->set))
        return -1;
    const size_t rows = s->friction ? 2 * (size_t)count : (size_t)count;
    double *columns = TAKE(s->arena, double, rows * s->n), *W = TAKE(s->arena, double, rows *rows);
    double *slips = TAKE(s->arena, double, contacts);
    char *holds = TAKE_ZEROS(s->arena, char, rows), *asked = TAKE_ZEROS(s->arena, char, count);
    if (count && !s->arena->ran_out && !delassus(s, f->y, count, f->set, columns, W)) {
        choose_rows(a, f, count, slips, holds, asked);
        hidden = masses_hide(s, f->y, count, f->set, holds, asked, W);
    }
    give_back(s->arena, mark);
    return hidden < 0 ? -1 : f->set[hidden];
}

/* Where a stage has failed so: where masses hide what contacts can do, nothing goes on; friction that jams has an impact without collision, once at an instant, all else goes on by time stepping. */
static enum outcome find_way_on(struct automaton *a, struct phase *f, enum outcome failed)
{
    int contact = -1;
    const int hidden = find_hidden(a, f);
    if (f->s->arena->has_run_out)
        return OUTCOME_NO_MEMORY;
    if (hidden >= 0) {
        f->run->contact = hidden;
        return OUTCOME_INEXACT;
    }
    if (failed == OUTCOME_JAMMED && !(a->jammed == f->t)) {
        const enum outcome outcome = strike_without_collision(f, &contact);
        if (outcome)
            return outcome;
        a->jammed = f->t;
    }
    const int collided = contact >= 0;
    if (!collided) {
        const enum outcome outcome = lay_flat(f, &contact);
        if (outcome)
            return outcome;
    }
    a->failed = failed;
    a->at_fault = f->run->contact;
    /* by other failures nothing has been shown to be at the end of its bounces */
    if (failed != OUTCOME_REPEATS && failed != OUTCOME_ACCUMULATION && failed != OUTCOME_CROWDED)
        memset(f->tight, 0, f->s->model->contacts * sizeof *f->tight);
    const int struck = contact >= 0; /* what led here is no longer what the state is about */
    const enum outcome outcome = struck ? OUTCOME_DONE : try_span(a, f);
    f->at.under_way = 0;
    if (outcome) {
        f->run->contact = a->at_fault;
        return contacts_have_none(outcome) ? failed : outcome;
    }
    a->event = struck ? (struct event){contact, 1.0, collided ? JAMS : CLOSES, 1.0} : NO_EVENT;
    a->loss = NO_LOSS;
    a->idle = 0;
    a->stage = struck ? STRIKE : STEP;
    return struck ? OUTCOME_DONE : begin_span(&a->span, f);
}

/* Whether the energy is more than before by no rounding: contacts have no energy to give. Each part of a stage sees to that by itself;
 * what none has thought of is caught here, and taken back. */
static int has_gained(struct phase *f, const struct before_stage *before)
{
    const struct system *s = f->s;
    double now[2];
    s->model->energy(s->k, f->y, f->y + s->n, now);
    const double gain = now[0] - before->energy[0] + (now[1] - before->energy[1]);
    if (gain <= ENERGY_JUMPED * (fmax(f->at.energy_in_motion, before->energy[0]) + s->energy))
        return 0;
    undo_stage(f, before);
    return 1;
}

/* Driven joints do work in impacts, and what takes time is looked after step by step. */
static int takes_no_time(const struct automaton *a, const struct phase *f)
{
    return !f->s->model->drives && (a->stage == MEET || a->stage == STRIKE || a->stage == SELECT);
}

int has_action(const struct automaton *a)
{
    return ACTIONS[a->stage] != NULL;
}

static enum outcome act(struct automaton *a, struct phase *f)
{
    if (!has_action(a))
        return OUTCOME_DONE;
    if (!takes_no_time(a, f))
        return ACTIONS[a->stage](a, f);
    const struct mark mark = f->s->arena->top;
    struct before_stage before;
    enum outcome outcome = note_stage(f, &before);
    outcome = outcome ? outcome : ACTIONS[a->stage](a, f);
    if (!outcome && has_gained(f, &before))
        outcome = OUTCOME_GAINED;
    give_back(f->s->arena, mark);
    return outcome;
}

/* Steps that shrink without end where the force of a contact that slides grows without bound are friction that jams. */
static enum outcome tell_jamming(const struct automaton *a, struct phase *f, enum outcome outcome)
{
    int contact = -1;
    if (a->stage != MOVE || (outcome != OUTCOME_STEP_TOO_SMALL && outcome != OUTCOME_NO_CONVERGENCE))
        return outcome;
    const enum outcome found = find_jamming(f, &contact);
    if (found || contact < 0)
        return found == OUTCOME_INTERRUPTED || found == OUTCOME_NO_MEMORY ? found : outcome;
    f->run->contact = contact;
    return OUTCOME_JAMMED;
}

static enum outcome run_one(struct automaton *a, struct phase *f)
{
    f->s->arena->has_run_out = 0;
    f->run->contact = -1; /* what fails says of which contact */
    enum outcome outcome = tell_jamming(a, f, act(a, f));
    if (f->s->arena->has_run_out) /* what was decided without all arrays is not to be trusted */
        outcome = OUTCOME_NO_MEMORY;
    if (may_step(a, f, outcome))
        return find_way_on(a, f, outcome);
    if (outcome)
        return outcome;
    if (has_action(a) && a->stage != MOVE && a->stage != STEP &&
        interrupted(f->s->interruption, 0)) /* what was found without accelerations is none */
        return OUTCOME_INTERRUPTED;
    size_t row = 0;
    while (TRANSITIONS[row].from != a->stage || (TRANSITIONS[row].guard && !TRANSITIONS[row].guard(a, f)))
        row++;
    a->stage = TRANSITIONS[row].to;
    return OUTCOME_DONE;
}

enum outcome run_stage(struct automaton *a, struct phase *f)
{
    const enum stage from = a->stage;
    const enum outcome outcome = run_one(a, f);
    const int pauses = (from == MOVE && a->stage == END) || (from == END && a->stage == MOVE);
    if ((a->stage != from && !pauses) ||
        outcome) { /* of where a call of its program ends and the next begins nothing is told */
        const int fails = outcome || a->stage == STEP;
        const enum outcome why = outcome ? outcome : fails && from != END ? a->failed : OUTCOME_DONE;
        trace(&f->run->trace,
              (struct traced){f->t, NAN, NAN, TRACED_STAGE, from, a->stage, a->event.contact, a->event.watch, why});
    }
    return outcome;
}
