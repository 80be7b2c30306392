/* Flight: steps in turn, and the search for events. */
#include "steps/phase.h"

#include <limits.h>
#include <math.h>
#include <string.h>

#include "base/tolerances.h"
#include "steps/energy_guard.h"
#include "steps/event_location.h"
#include "steps/pace.h"
#include "steps/scene_events.h"
#include "steps/step_control.h"
#include "steps/step_end.h"
#include "steps/kinks.h"
#include "steps/meeting.h"
#include "motion/sides.h"
#include "motion/switching.h"
#include "model/contacts.h"
#include "model/scales.h"

enum {
    SHORTER = 60,   /* shorter steps in search of an early event */
    LARGEST = 1024, /* coordinates of what follows branches: its memory goes as their square */
    CRAWLS = 20     /* steps in a row that move nothing, before what they might be stuck at is looked at */
};

int take_phase(struct phase *f)
{
    struct system *s = f->s;
    struct arena *arena = s->arena;
    const struct method *method = f->run->method;
    const size_t size = s->size, c = s->model->contacts;
    const int passes = s->model->rows && s->model->stages && method->damps && f->run->fixed_step == 0.0;
    f->y = TAKE_ZEROS(arena, double, size);
    f->dy = TAKE_ZEROS(arena, double, size);
    f->y1 = TAKE_ZEROS(arena, double, size);
    f->dy1 = TAKE_ZEROS(arena, double, size);
    f->scratch = TAKE_ZEROS(arena, double, method->scratch(s)); /* a method finds zeros */
    f->passing = passes ? TAKE_ZEROS(arena, double, gauss.scratch(s)) : NULL;
    f->branch.chart = NULL;
    if (s->model->rows && s->model->stages && s->n <= LARGEST && take_branch(arena, s->model, &f->branch))
        return 1;
    f->branch.place = TAKE_ZEROS(arena, double, s->n);
    f->branch.offset = TAKE_ZEROS(arena, double, s->model->rows);
    f->branch.heading = TAKE_ZEROS(arena, double, s->n);
    f->noted_place = TAKE_ZEROS(arena, double, 2 * (size_t)s->n + s->model->rows);
    f->kept = TAKE_ZEROS(arena, double, memory_size(method, s));
    f->peak = TAKE_ZEROS(arena, double, c);
    f->gaps = TAKE_ZEROS(arena, double, c);
    f->rates = TAKE_ZEROS(arena, double, c);
    f->met = TAKE_ZEROS(arena, int, c);
    f->tight = TAKE_ZEROS(arena, int, c);
    f->sides = TAKE_ZEROS(arena, double, s->model->switches);
    f->latched = TAKE_ZEROS(arena, double, s->model->latches);
    f->kink = -1;
    f->set = TAKE_ZEROS(arena, int, c);
    if (take_active_set(arena, &f->active, s->model))
        return 1;
    s->active = c ? &f->active : NULL;
    s->latched = f->latched;
    return 0;
}

/* The first of the watched values by which a carried contact bears, or -1 */
static int bearing(const struct system *s, const double *values)
{
    for (int w = 0; w < switching_count(s); w++)
        if (values[w] < 0.0 && mode_change_of(s, w).how == BEARS)
            return w;
    return -1;
}

/* Whether a carried contact really comes to bear in the step, where the dense output shows one or at the end, and which: that output is not put back onto
 * the contacts, and shows what is not. The step is the whole one again. */
static enum outcome confirm_bearing(struct phase *f, struct event *event)
{
    struct system *s = f->s;
    const struct mark mark = s->arena->top;
    const double whole = f->h;
    double *values = TAKE(s->arena, double, switching_count(s));
    enum outcome outcome = s->arena->ran_out ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    event->watch = -1;
    for (int i = 0; i < 2 && event->watch < 0 && !outcome; i++) {
        event->behind = i ? 1.0 : event->behind;
        if (event->behind < 1.0 || i)
            outcome = projected_step(f, event->behind * whole);
        outcome = outcome ? outcome : switching_functions(s, f->t + event->behind * whole, f->y1, f->dy1, values);
        event->watch = outcome ? -1 : bearing(s, values);
    }
    if (event->watch >= 0)
        event->contact = mode_change_of(s, event->watch).contact;
    if (!outcome && event->behind < 1.0)
        outcome = projected_step(f, whole);
    give_back(s->arena, mark);
    return outcome;
}

/* Prepare the dense output of the step just taken and look for its first event. An event early in a long step is looked for
 * again in a shorter one, until it lies well inside: the dense output of a long step is too coarse for a short bounce. If a
 * shorter step turns out to have no event, it stands as the step taken. */
static enum outcome search_step(struct phase *f, struct event *event)
{
    int bears = 1;
    for (int i = 0;; i++) {
        enum outcome outcome = evaluate_end_derivative(f);
        if (!outcome)
            outcome = f->by->prepare(f->s, f->steps, f->t, f->h, f->y, f->dy, f->y1, f->dy1);
        if (outcome)
            return outcome;
        if ((outcome = find_event(f->s, f->by, f->steps, f->t, f->h, rest_speed(f) / f->s->time, bears, event)))
            return outcome;
        if (event->watch >= 0 && mode_change_of(f->s, event->watch).how == BEARS) {
            if ((outcome = confirm_bearing(f, event)))
                return outcome;
            if ((bears = event->watch >= 0) == 0) /* looked at again without that */
                continue;
        }
        const double shorter = 2.0 * event->theta * f->h;
        if (event->contact < 0 || event->theta > EARLY || f->t + shorter <= f->t || i == SHORTER)
            return OUTCOME_DONE;
        f->h = shorter;
        if ((outcome = projected_step(f, f->h)))
            return outcome;
    }
}

/* Whether a contact that others carry is not closed any more: what carries it has changed. */
static int opened_implied_contact(const struct phase *f)
{
    const struct ccgen_model *m = f->s->model;
    if (!f->s->active || !f->s->active->implied)
        return -1;
    contact_gaps(f->s, f->y, f->gaps);
    for (int c = 0; c < m->contacts; c++)
        if (f->s->active->closed[c] == CARRIED && fabs(f->gaps[c]) > ADRIFT * f->s->extent[c])
            return c;
    return -1;
}

/* A contact that is not held and has come to lie behind its surface, or deeper, at the end of the step, or -1: an event has
 * escaped */
static int penetrating_contact(const struct phase *f)
{
    const struct ccgen_model *m = f->s->model;
    double *before = f->rates;
    int known = 0;
    if (!m->contacts)
        return -1;
    contact_gaps(f->s, f->y1, f->gaps);
    for (int c = 0; c < m->contacts; c++) {
        if (f->s->active->closed[c] == PUSHING || !(f->gaps[c] < -ADRIFT * f->s->extent[c]))
            continue;
        if (!known++) /* few steps ask for it */
            contact_gaps(f->s, f->y, before);
        if (f->gaps[c] < fmin(-ADRIFT * f->s->extent[c], before[c] - PENETRATION * f->s->extent[c]))
            return c;
    }
    return -1;
}

/* Where a phase begins: sides of effects, derivative, first step, and a method that knows of no step before */
static enum outcome begin_phase(struct phase *f)
{
    const struct run *run = f->run;
    enum outcome outcome = begin_sides(f);
    const int beside = f->at.follows || !f->run->steps; /* where the phase before has ended, or unknown */
    f->at.follows = 0;
    outcome = outcome || !beside ? outcome : follow_if_beside(f);
    if (outcome == OUTCOME_NO_BRANCH && (f->run->steps || f->run->events))
        outcome = OUTCOME_DONE; /* what rounding and impacts make of a motion is no fault of its start */
    outcome = outcome || f->s->branch ? outcome : evaluate_derivative(f);
    f->at.since = f->t;
    f->at.energy_known = f->at.crawled = 0;
    f->at.late = f->at.refused = 0.0;
    if (run->method->restart)
        run->method->restart(f->scratch, f->s->size);
    if (!outcome && f->h <= 0.0)
        f->h = run->fixed_step > 0.0 ? run->fixed_step : first_step(f);
    if (!outcome && interrupted(f->s->interruption, 0)) /* what was found without accelerations is none */
        outcome = OUTCOME_INTERRUPTED;
    f->at.next = f->h;
    f->at.under_way = !outcome;
    return outcome;
}

/* What a step that is begun and not ended has changed */
struct before_step {
    struct progress at;
    int rank, placed;
    double h, window;
    long steps, rejected;
};

static struct before_step note_step(struct phase *f)
{
    if (f->run->method->memory)
        f->run->method->memory(f->s, f->scratch, 0, f->kept);
    if (f->s->active)
        memcpy(f->peak, f->active.peak, f->s->model->contacts * sizeof *f->peak);
    memcpy(f->noted_place, f->branch.place, f->s->n * sizeof *f->noted_place);
    memcpy(f->noted_place + f->s->n, f->branch.heading, f->s->n * sizeof *f->noted_place);
    memcpy(f->noted_place + 2 * f->s->n, f->branch.offset, f->s->model->rows * sizeof *f->noted_place);
    return (struct before_step){.at = f->at,
                                .rank = f->branch.rank,
                                .placed = f->branch.placed,
                                .h = f->h,
                                .window = f->active.window,
                                .steps = f->run->steps,
                                .rejected = f->run->rejected};
}

/* As if the step had not been begun: what was interrupted goes on as if it had not been. */
static void undo_step(struct phase *f, const struct before_step *before)
{
    if (f->run->method->memory)
        f->run->method->memory(f->s, f->scratch, 1, f->kept);
    if (f->s->active)
        memcpy(f->active.peak, f->peak, f->s->model->contacts * sizeof *f->peak);
    f->active.window = before->window;
    memcpy(f->branch.place, f->noted_place, f->s->n * sizeof *f->noted_place);
    memcpy(f->branch.heading, f->noted_place + f->s->n, f->s->n * sizeof *f->noted_place);
    memcpy(f->branch.offset, f->noted_place + 2 * f->s->n, f->s->model->rows * sizeof *f->noted_place);
    f->branch.rank = before->rank;
    f->branch.placed = before->placed;
    f->at = before->at;
    f->h = before->h;
    f->run->steps = before->steps;
    f->run->rejected = before->rejected;
}

/* The effect f->kink comes to the other side: what the method knows of the steps before is of no use beyond. */
static enum outcome pass_kink(struct phase *f)
{
    enum outcome outcome = change_side(f, f->kink);
    trace(&f->run->trace, (struct traced){f->t, NAN, NAN, TRACED_KINK, f->kink, -1, -1, 0, OUTCOME_DONE});
    f->kink = -1;
    if (f->run->method->restart)
        f->run->method->restart(f->scratch, f->s->size);
    outcome = outcome ? outcome : evaluate_derivative(f);
    f->at.under_way &= !outcome; /* who goes on then finds the derivative first */
    return outcome;
}

/* Whether an effect really is on the other side behind its kink: where held contacts or loops keep its function at zero, the dense output, which is
 * not put back onto them, crosses it by what it misses. The step is the whole one again. */
static enum outcome confirm_kink(struct phase *f, const struct event *kink, int *is_one)
{
    struct system *s = f->s;
    const struct mark mark = s->arena->top;
    const size_t switches = s->model->switches;
    double *value = TAKE(s->arena, double, switches), *there = TAKE(s->arena, double, switches);
    double *noise = TAKE(s->arena, double, switches), *moved = TAKE(s->arena, double, s->size);
    const double t = f->t + kink->behind * f->h;
    enum outcome outcome = s->arena->ran_out ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    if (!outcome && kink->behind < 1.0)
        outcome = projected_step(f, kink->behind * f->h);
    outcome = outcome ? outcome : side_noise(s, t, f->y1, moved, value, there, noise);
    outcome = outcome ? outcome : side_functions(s, t, f->y1, s->sides, value);
    *is_one = !outcome && value[kink->watch] < -noise[kink->watch];
    if (!outcome && kink->behind < 1.0)
        outcome = projected_step(f, f->h);
    give_back(s->arena, mark);
    return outcome;
}

/* Have the step just taken end at its first kink, so that all of it is smooth: no method keeps its order across one. */
static enum outcome end_at_kink(struct phase *f)
{
    struct event kink;
    if (!f->s->model->switches)
        return OUTCOME_DONE;
    enum outcome outcome = evaluate_end_derivative(f);
    outcome = outcome ? outcome : f->by->prepare(f->s, f->steps, f->t, f->h, f->y, f->dy, f->y1, f->dy1);
    outcome = outcome ? outcome : find_kink(f->s, f->by, f->steps, f->t, f->h, &kink);
    int is_one = 0;
    if (!outcome && kink.watch >= 0)
        outcome = confirm_kink(f, &kink, &is_one);
    if (outcome || !is_one)
        return outcome;
    f->kink = kink.watch;
    return locate_kink(f, kink);
}

/* Begin a try: f->h is as long as is wanted, or all that is left to the next stop, whose time is returned. */
static double begin_try(struct phase *f, double *wanted, double *left)
{
    const struct run *run = f->run;
    struct progress *at = &f->at;
    const double usual = run->fixed_step > 0.0 ? run->fixed_step : at->next, next = next_stop(run, f->t);
    *wanted = at->meets > 0.0 ? fmin(at->meets, usual) : usual;
    const int last = f->t + 1.01 * *wanted >= next;
    *left = next - f->t - at->late;
    f->h = last ? *left : *wanted;
    at->longest = at->refused > 0.0 ? fmin(at->refused, *left) : *left;
    at->bounded = last;
    return next;
}

/* One step, or the part of it up to its first kink or event, to y1 a time f->h later. Its end is `stop`, unless that is NAN. Where no
 * step ends there, *again is set, and the next try is shorter. */
static enum outcome try_step(struct phase *f, struct event *event, double *stop, int *again)
{
    struct run *run = f->run;
    struct progress *at = &f->at;
    double wanted, left;
    const double next = begin_try(f, &wanted, &left), whole = f->h;
    *again = 0;
    enum outcome outcome = accepted_step(f, &at->next);
    if (outcome)
        return outcome;
    if (f->h == left)
        at->next = fmax(at->next, wanted);
    if ((outcome = refuse_before_meeting(f, again)) || *again)
        return outcome;
    f->kink = -1;
    if (f->flips <= 2 * f->s->model->switches && (outcome = end_at_kink(f))) /* more at one instant are rounding */
        return outcome;
    if (f->kink >= 0 && !(f->t + f->h > f->t)) { /* it begins there */
        at->next = fmin(at->next,
                        LEAST_CHANGE * whole); /* where it crosses again at once, shorter steps show what is rounding */
        at->refused = at->next;
        f->flips++;
        *again = 1;
        return OUTCOME_DONE;
    }
    const double smooth = f->h;
    outcome = f->s->model->contacts ? search_step(f, event) : evaluate_end_derivative(f);
    f->events = !outcome && run->watched ? where_events_may_be(f) : UCHAR_MAX;
    if (event->contact >= 0 || f->h != smooth)
        f->kink = -1;
    if (!outcome && interrupted(f->s->interruption, 0)) /* what was found without accelerations is none */
        outcome = OUTCOME_INTERRUPTED;
    if (!outcome && event->contact >= 0)
        outcome = locate_event(f, *event);
    if (!outcome && event->contact >= 0 && f->h > shortest(f) && outruns_velocity(f))
        outcome = OUTCOME_STEP_TOO_SMALL;
    double unknown;
    if (!outcome && f->h != at->energy_h && f->h > shortest(f) &&
        energy_residual(f, &unknown) > 1.0) /* shorter than accepted */
        outcome = OUTCOME_STEP_TOO_SMALL;
    const int behind = outcome ? -1 : penetrating_contact(f);
    if (behind >= 0 && (f->s->active->closed[behind] == WATCHED || f->h > shortest(f))) {
        run->contact = behind;
        outcome = OUTCOME_ESCAPED;
    }
    if (!outcome && turned_far(f->s, f->y1))
        outcome = OUTCOME_TURNED_FAR;
    if (outcome && outcome != OUTCOME_INTERRUPTED && run->fixed_step == 0.0 && f->h > shortest(f)) {
        f->kink = -1;
        at->refused = at->next = LEAST_CHANGE * f->h; /* no step ends there, or it ends too late: come nearer first */
        event->contact = -1;
        run->rejected++;
        trace(&run->trace, (struct traced){f->t, f->h, NAN, TRACED_REFUSAL, -1, -1, behind, 0, outcome});
        *again = 1;
        return OUTCOME_DONE;
    }
    *stop = f->h == left ? next : NAN;
    return outcome;
}

/* Go on to the end of a step that met no event. */
static void commit_step(struct phase *f, double stop)
{
    struct progress *at = &f->at;
    f->flips = 0;
    at->refused = 0.0;
    commit_energy(f);
    const double step = f->h + at->late, then = isnan(stop) ? f->t + step : stop;
    at->late = then == stop ? 0.0 : step - (then - f->t);
    f->t = then;
    double *swap = f->y;
    f->y = f->y1;
    f->y1 = swap;
    swap = f->dy;
    f->dy = f->dy1;
    f->dy1 = swap;
}

/* Go on to the event that the step ends at. */
static void commit_event(struct phase *f)
{
    f->t += f->h;
    memcpy(f->y, f->y1, (size_t)f->s->size * sizeof *f->y);
    f->at.next = fmin(f->at.next, LONGEST_REBOUND * (f->t - f->at.since));
    f->at.refused = 0.0;
}

/* Events that show in a state, not between two: what others carried is open, or links cannot move */
static enum outcome find_standing_event(struct phase *f, struct event *event)
{
    struct progress *at = &f->at;
    enum outcome outcome = OUTCOME_DONE;
    if ((event->contact = opened_implied_contact(f)) >= 0) {
        event->watch = LOST;
        return outcome;
    }
    at->crawled = stalls(f) ? at->crawled + 1 : 0;
    if (at->crawled <= 1)
        at->crawls_since = f->t;
    if (!at->crawled || at->crawled % CRAWLS)
        return outcome;
    if (is_stuck(f)) {
        at->crawled = 0; /* who goes on may crawl as long again */
        outcome = OUTCOME_STEP_TOO_SMALL;
    }
    return outcome;
}

static enum outcome go_to_event(struct phase *f, struct event *event)
{
    enum outcome outcome = f->at.under_way ? OUTCOME_DONE : begin_phase(f);
    event->contact = -1;
    while (!outcome && f->t < f->run->until && event->contact < 0 && !f->run->paused) {
        if ((outcome = within_budget(f)))
            break;
        const struct before_step before = note_step(f);
        double stop = NAN;
        int again;
        outcome = try_step(f, event, &stop, &again);
        if (outcome == OUTCOME_INTERRUPTED) {
            undo_step(f, &before);
            event->contact = -1;
        }
        if (!outcome && again && f->kink >= 0)
            outcome = pass_kink(f);
        if (outcome || again)
            continue;
        /* of a step that ends early the eighths are others */
        const unsigned char events = event->contact >= 0 && f->events ? UCHAR_MAX : f->events;
        f->run->paused = f->run->pauses == BEHIND_A_STEP || (f->run->pauses == BEFORE_EVENTS && events);
        if (f->run->paused && f->run->pauses == BEFORE_EVENTS) {
            undo_step(f, &before);
            event->contact = -1;
            break;
        }
        excuse_progress(f, before.steps + before.rejected);
        const double from = f->t;
        if (event->contact >= 0)
            commit_event(f);
        else
            commit_step(f, stop);
        f->run->record.told_from = from;
        f->run->record.told_to = f->t;
        f->run->record.told = events;
        if (event->contact >= 0)
            break;
        outcome = record_state(f) ? OUTCOME_NO_MEMORY : find_standing_event(f, event);
        if (!outcome && f->kink >= 0 && event->contact < 0)
            outcome = pass_kink(f);
    }
    f->h = f->at.next;
    f->at.under_way &= event->contact < 0;
    f->s->branch = NULL; /* decisions and impacts begin one anew */
    return outcome;
}

enum outcome integrate_to_event(struct phase *f, struct event *event)
{
    f->s->sides = f->sides;
    const enum outcome outcome = go_to_event(f, event);
    f->s->sides = NULL; /* between phases each state is on the side on which it is */
    return outcome;
}
