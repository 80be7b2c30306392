/* The hybrid run: flight until an event or the end, impact at the event, flight again. */
#include "run.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "events.h"

static const double SAFETY = 0.9, LEAST_CHANGE = 0.2, LARGEST_CHANGE = 6.0;
static const double EARLY = 0.05;             /* part of a step: events before it are looked for in a shorter step */
static const double LONGEST_REBOUND = 10.0;   /* times the flight before an impact: the first step tried after it */
static const double REST_SPEED = 1e-10;       /* times length per second: a contact this slow does not bounce */
static const double REST_ACCELERATION = 1e-6; /* times length per second squared: a gap this slow is not pressed shut */
static const double ACCUMULATION_REST = 1e-9; /* s left until impacts accumulate, relative to max(1, t) */
enum {
    SHORTER = 60,  /* shorter steps in search of an early event */
    LANDINGS = 60, /* steps towards an event; three to five are usual */
    REPEATS = 100, /* impacts at one instant */
    ALIKE = 5,     /* intervals in steady proportion before impacts are said to accumulate */
    CROWD = 40,    /* events within the time that counts as none */
    TICK = 64      /* steps between looks at the outside world */
};

/* How the impacts of one contact follow each other. */
struct history {
    double t, interval, ratio;
    int count; /* impacts so far */
    int alike; /* consecutive intervals that shrink by about the same ratio */
};

struct flight {
    struct system *s;
    struct run *run;
    double *block; /* all numbers of the flight */
    double t, h;
    double *y, *dy, *y1, *dy1; /* state and derivative at t, and at the end of the step */
    double *scratch;           /* of the method */
    double *search;            /* of the event search */
    double *gaps, *rates, *e, *P;
    int *set;
    struct history *history;
};

/* speed (m/s) below which a closed contact neither opens nor closes */
static double slow(const struct flight *f)
{
    return REST_SPEED * f->s->length;
}

static enum outcome derive(struct flight *f)
{
    return system_derivative(f->s, f->t, f->y, f->dy);
}

/* First step size by comparing an Euler step with its derivative (Hairer, Norsett, Wanner 1993, section II.4). */
static double first_step(struct flight *f)
{
    const int n = 2 * f->s->n;
    const struct tolerance tol = f->run->tolerance;
    double d0 = 0.0, d1 = 0.0, d2 = 0.0;
    for (int i = 0; i < n; i++) {
        const double scale = tol.atol + tol.rtol * fabs(f->y[i]);
        d0 += (f->y[i] / scale) * (f->y[i] / scale);
        d1 += (f->dy[i] / scale) * (f->dy[i] / scale);
    }
    d0 = sqrt(d0 / n);
    d1 = sqrt(d1 / n);
    const double least = 1e-12 * fmax(fabs(f->t), 1e-3);
    const double h0 = d0 < 1e-5 || d1 < 1e-5 ? 1e-6 : fmax(0.01 * d0 / d1, least);
    for (int i = 0; i < n; i++)
        f->y1[i] = f->y[i] + h0 * f->dy[i];
    if (system_derivative(f->s, f->t + h0, f->y1, f->dy1))
        return h0;
    for (int i = 0; i < n; i++) {
        const double scale = tol.atol + tol.rtol * fabs(f->y[i]);
        d2 += ((f->dy1[i] - f->dy[i]) / scale) * ((f->dy1[i] - f->dy[i]) / scale);
    }
    d2 = sqrt(d2 / n) / h0;
    const double largest = fmax(d1, d2);
    const double h1 = largest <= 1e-15 ? fmax(1e-6, 1e-3 * h0) : pow(0.01 / largest, 1.0 / f->run->method->order);
    return h1 > least ? fmin(100.0 * h0, h1) : least;
}

/* Put the end of a step back onto the closure. */
static enum outcome project_end(struct flight *f)
{
    const enum outcome outcome = project_position(f->s, f->y1);
    return outcome ? outcome : project_velocity(f->s, f->y1, f->y1 + f->s->n);
}

/* Step of length h from (t, y) to y1, not projected yet. */
static enum outcome raw_step(struct flight *f, double h, double *error)
{
    return f->run->method->step(f->s, f->scratch, f->t, h, f->y, f->dy, f->run->tolerance, f->y1, error);
}

/* Step of length h, put back onto the closure whatever its error. */
static enum outcome plain_step(struct flight *f, double h)
{
    double error;
    const enum outcome outcome = raw_step(f, h, &error);
    return outcome ? outcome : project_end(f);
}

/* Step until the error test passes; the step's length is in f->h before and after, `next` is the one to try then. */
static enum outcome accepted_step(struct flight *f, double *next)
{
    struct run *run = f->run;
    const double least = 16.0 * DBL_EPSILON * fmax(fabs(f->t), 1e-3);
    int refused = 0;
    for (;;) {
        double error = 0.0;
        enum outcome outcome = raw_step(f, f->h, &error);
        if (run->fixed_step > 0.0)
            error = 0.0;
        if (!outcome && error <= 1.0)
            outcome = project_end(f);
        if (!outcome && error <= 1.0) {
            const double change = SAFETY * pow(fmax(error, 1e-12), -1.0 / run->method->order);
            *next = f->h * fmin(fmax(change, LEAST_CHANGE), refused ? 1.0 : LARGEST_CHANGE);
            run->steps++;
            return OUTCOME_DONE;
        }
        refused = 1;
        run->rejected++;
        const double change = outcome || !isfinite(error) ? LEAST_CHANGE : SAFETY * pow(error, -1.0 / run->method->order);
        f->h *= fmax(change, LEAST_CHANGE);
        if (f->h < least || run->fixed_step > 0.0)
            return outcome ? outcome : OUTCOME_STEP_TOO_SMALL;
    }
}

/* Prepare the dense output of the step just taken and look for its first event. An event early in a long step is looked for
 * again in a shorter one, until it lies well inside: the dense output of a long step is too coarse for a short bounce. If a
 * shorter step turns out to have no event, it stands as the step taken. */
static enum outcome search_step(struct flight *f, struct event *event)
{
    for (int i = 0;; i++) {
        enum outcome outcome = system_derivative(f->s, f->t + f->h, f->y1, f->dy1);
        if (!outcome)
            outcome = f->run->method->prepare(f->s, f->scratch, f->t, f->h, f->y, f->dy, f->y1, f->dy1);
        if (outcome)
            return outcome;
        *event = find_event(f->s, f->run->method, f->scratch, slow(f), f->search);
        const double shorter = 2.0 * event->theta * f->h;
        if (event->contact < 0 || event->theta > EARLY || f->t + shorter <= f->t || i == SHORTER)
            return OUTCOME_DONE;
        f->h = shorter;
        if ((outcome = plain_step(f, f->h)))
            return outcome;
    }
}

/* Step again from (t, y) so that the step ends at the event: Newton on the gap, kept inside the bracket of what is known.
 * y1 is then the state at t + h, as accurate as any step's end. */
static enum outcome land(struct flight *f, struct event event)
{
    const struct ccgen_model *m = f->s->model;
    double h = event.theta * f->h, before = 0.0, behind = f->h;
    for (int i = 0; f->t + h > f->t; i++) {
        const enum outcome outcome = plain_step(f, h);
        if (outcome)
            return outcome;
        m->gaps(f->s->k, f->y1, f->gaps);
        m->gap_rates(f->s->k, f->y1, f->y1 + f->s->n, f->rates);
        const double g = f->gaps[event.contact], rate = f->rates[event.contact];
        const double resolution = DBL_EPSILON * fmax(f->t + h, f->h);
        if (g > 0.0)
            before = h;
        else
            behind = h;
        double next = rate < 0.0 ? h - g / rate : h;
        if (fabs(next - h) <= resolution || behind - before <= resolution || i == LANDINGS) {
            f->h = h;
            return OUTCOME_DONE;
        }
        h = next > before && next < behind ? next : 0.5 * (before + behind);
    }
    memcpy(f->y1, f->y, 2 * f->s->n * sizeof *f->y); /* the event is where the step begins */
    f->h = 0.0;
    return OUTCOME_DONE;
}

/* Record the present state, unless it is the last row already. */
static int keep(struct flight *f)
{
    const struct record *r = &f->run->record;
    const size_t width = 2 * (size_t)f->s->n;
    if (r->count && r->t[r->count - 1] == f->t && !memcmp(r->y + (r->count - 1) * width, f->y, width * sizeof *f->y))
        return 0;
    return append_row(&f->run->record, f->t, f->y, 2 * f->s->n);
}

/* Flight to the end of the run, or to the first event: *contact is then the one that triggers. */
static enum outcome fly(struct flight *f, int *contact)
{
    struct run *run = f->run;
    const double since = f->t;
    enum outcome outcome = derive(f);
    *contact = -1;
    if (!outcome && f->h <= 0.0)
        f->h = run->fixed_step > 0.0 ? run->fixed_step : first_step(f);
    double next = f->h;
    while (!outcome && f->t < run->until) {
        if (run->steps % TICK == 0 && run->tick && run->tick(run->context, f->t))
            return OUTCOME_INTERRUPTED;
        if (run->steps + run->rejected >= run->step_budget)
            return OUTCOME_BUDGET;
        const double wanted = run->fixed_step > 0.0 ? run->fixed_step : next;
        const int last = f->t + 1.01 * wanted >= run->until;
        const double whole = last ? run->until - f->t : wanted;
        f->h = whole;
        if ((outcome = accepted_step(f, &next)))
            break;
        if (last && f->h == whole)
            next = fmax(next, wanted);
        struct event event = {-1, 0.0};
        outcome = f->s->model->contacts ? search_step(f, &event)
                                        : system_derivative(f->s, f->t + f->h, f->y1, f->dy1);
        if (!outcome && event.contact >= 0) {
            if ((outcome = land(f, event)))
                break;
            f->t += f->h;
            memcpy(f->y, f->y1, 2 * f->s->n * sizeof *f->y);
            f->h = fmin(next, LONGEST_REBOUND * (f->t - since));
            *contact = event.contact;
            return OUTCOME_DONE;
        }
        if (outcome)
            break;
        f->t = last && f->h == whole ? run->until : f->t + f->h;
        double *swap = f->y;
        f->y = f->y1;
        f->y1 = swap;
        swap = f->dy;
        f->dy = f->dy1;
        f->dy1 = swap;
        if (keep(f))
            return OUTCOME_NO_MEMORY;
    }
    f->h = next;
    return outcome;
}

/* Time from the last impact to the limit of a geometric sequence of intervals */
static double rest_of(const struct history *past)
{
    return past->interval * past->ratio / (1.0 - past->ratio);
}

/* Note an impact of a contact; nonzero when its impacts accumulate: intervals shrink by a steady ratio and hardly any time
 * is left to their limit. */
static int accumulates(struct flight *f, int contact)
{
    struct history *past = &f->history[contact];
    const double interval = past->count ? f->t - past->t : 0.0;
    const double ratio = past->interval > 0.0 ? interval / past->interval : 0.0;
    const int steady = ratio > 0.0 && ratio < 1.0 && fabs(ratio - past->ratio) <= 0.05 * ratio;
    past->alike = steady ? past->alike + 1 : 0;
    past->count++;
    past->t = f->t;
    past->interval = interval;
    past->ratio = ratio;
    const double rest = steady ? rest_of(past) : INFINITY;
    if (past->alike < ALIKE || rest > ACCUMULATION_REST * fmax(1.0, fabs(f->t)))
        return 0;
    f->run->accumulation = f->t + rest;
    f->run->contact = contact;
    return 1;
}

/* Whether a contact that neither opens nor closes is pressed shut: its gap accelerates inwards, beyond rounding. */
static int pressed(struct flight *f, int contact)
{
    const struct ccgen_model *m = f->s->model;
    const int n = f->s->n;
    const double step = 1e-6;
    if (system_derivative(f->s, f->t, f->y, f->dy))
        return 0;
    double rate[2];
    for (int side = 0; side < 2; side++) {
        for (int i = 0; i < 2 * n; i++)
            f->y1[i] = f->y[i] + (side ? step : -step) * f->dy[i];
        m->gap_rates(f->s->k, f->y1, f->y1 + n, f->rates);
        rate[side] = f->rates[contact];
    }
    return rate[1] - rate[0] < -2.0 * step * REST_ACCELERATION * f->s->length;
}

/* A closed contact that stays closed, or -1. */
static int resting(struct flight *f, double closed, double still)
{
    const struct ccgen_model *m = f->s->model;
    m->gaps(f->s->k, f->y, f->gaps);
    for (int c = 0; c < m->contacts; c++) {
        m->gap_rates(f->s->k, f->y, f->y + f->s->n, f->rates);
        if (f->gaps[c] <= closed && fabs(f->rates[c]) <= still && pressed(f, c))
            return c;
    }
    return -1;
}

/* All impacts of one instant: those contacts that are closed and not opening are struck together; if a closed contact is
 * left approaching, another impact follows. `trigger` is the contact whose event led here, or -1. */
static enum outcome strike(struct flight *f, int trigger)
{
    const struct ccgen_model *m = f->s->model;
    struct run *run = f->run;
    const int n = f->s->n;
    const double closed = fmin(fmax(run->tolerance.rtol, 1e-12), 1e-8) * f->s->length, still = slow(f);
    int accumulating = 0;
    for (int repeat = 0;; repeat++) {
        int count = 0, approaching = 0;
        m->gaps(f->s->k, f->y, f->gaps);
        m->gap_rates(f->s->k, f->y, f->y + n, f->rates);
        for (int c = 0; c < m->contacts; c++)
            if ((f->gaps[c] <= closed || (c == trigger && !repeat)) && f->rates[c] <= still) {
                approaching |= f->rates[c] < -still || (c == trigger && !repeat && f->rates[c] < 0.0);
                f->e[count] = f->s->restitution[c];
                f->set[count++] = c;
            }
        if (!approaching)
            break;
        if (repeat == REPEATS)
            return OUTCOME_REPEATS;
        double *u_plus = f->y1 + n;
        enum outcome outcome = impact(f->s, f->y, f->y + n, count, f->set, f->e, u_plus, f->P);
        if (outcome)
            return outcome;
        double loss = 0.0;
        double *after = f->search;
        m->gap_rates(f->s->k, f->y, u_plus, after);
        for (int i = 0; i < count; i++)
            loss -= 0.5 * f->P[i] * (f->rates[f->set[i]] + after[f->set[i]]);
        if (keep(f) || append_impact(&run->impacts, f->t, f->y + n, u_plus, n, count, f->set, f->P, loss, run->record.count))
            return OUTCOME_NO_MEMORY;
        memcpy(f->y + n, u_plus, n * sizeof *u_plus);
        if (keep(f))
            return OUTCOME_NO_MEMORY;
        for (int i = 0; i < count; i++)
            if (f->P[i] > 0.0 && !repeat)
                accumulating |= accumulates(f, f->set[i]);
    }
    if (accumulating)
        return OUTCOME_ACCUMULATION;
    const int contact = resting(f, closed, still);
    if (contact < 0)
        return OUTCOME_DONE;
    run->contact = contact;
    const struct history *past = &f->history[contact];
    if (!(past->ratio > 0.0 && past->ratio < 1.0))
        return OUTCOME_SUSTAINED;
    run->accumulation = past->t + rest_of(past); /* it came to rest by ever smaller bounces */
    return OUTCOME_ACCUMULATION;
}

/* The hybrid automaton: impact wherever flight ends at an event. */
static enum outcome alternate(struct flight *f)
{
    enum outcome outcome = OUTCOME_DONE;
    double last[CROWD]; /* instants of the last events */
    int contact, events = 0;
    if (f->s->model->contacts)
        outcome = strike(f, -1);
    while (!outcome && f->t < f->run->until) {
        outcome = fly(f, &contact);
        if (outcome || contact < 0)
            continue;
        outcome = strike(f, contact);
        if (!outcome && events >= CROWD && f->t - last[events % CROWD] <= ACCUMULATION_REST * fmax(1.0, f->t)) {
            f->run->contact = contact;
            f->run->accumulation = f->t;
            outcome = OUTCOME_ACCUMULATION;
        }
        last[events++ % CROWD] = f->t;
    }
    return outcome;
}

/* All scratch of a flight in two blocks; 0, or 1 when memory runs out. */
static int make_room(struct flight *f)
{
    const size_t n = 2 * (size_t)f->s->n, c = f->s->model->contacts, scratch = f->run->method->scratch((int)n);
    f->block = malloc((4 * n + scratch + n + 5 * c + 4 * c + 1) * sizeof *f->block);
    f->set = malloc((c + 1) * sizeof *f->set);
    f->history = calloc(c + 1, sizeof *f->history);
    f->y = f->block;
    if (!f->block || !f->set || !f->history)
        return 1;
    f->dy = f->y + n;
    f->y1 = f->dy + n;
    f->dy1 = f->y1 + n;
    f->scratch = f->dy1 + n;
    f->search = f->scratch + scratch;
    f->gaps = f->search + n + 5 * c;
    f->rates = f->gaps + c;
    f->e = f->rates + c;
    f->P = f->e + c;
    return 0;
}

static void free_room(struct flight *f)
{
    free(f->block);
    free(f->set);
    free(f->history);
}

void simulate(struct system *s, struct run *run, double *y)
{
    struct flight f = {.s = s, .run = run, .t = run->start};
    run->contact = -1;
    run->outcome = OUTCOME_NO_MEMORY;
    if (!make_room(&f)) {
        memcpy(f.y, y, 2 * (size_t)s->n * sizeof *y);
        run->outcome = project_position(s, f.y);
        if (!run->outcome)
            run->outcome = project_velocity(s, f.y, f.y + s->n);
        if (!run->outcome && keep(&f))
            run->outcome = OUTCOME_NO_MEMORY;
        if (!run->outcome)
            run->outcome = alternate(&f);
        if (run->record.count && f.t > run->record.t[run->record.count - 1] && keep(&f))
            run->outcome = OUTCOME_NO_MEMORY;
    }
    run->t = f.t;
    free_room(&f);
}

enum outcome advance(struct system *s, const struct method *method, double t, double h, double *y)
{
    struct run run = {.method = method, .tolerance = {1.0, 1.0}};
    struct flight f = {.s = s, .run = &run, .t = t};
    enum outcome outcome = OUTCOME_NO_MEMORY;
    if (!make_room(&f)) {
        memcpy(f.y, y, 2 * (size_t)s->n * sizeof *y);
        outcome = derive(&f);
        if (!outcome && !(outcome = plain_step(&f, h)))
            memcpy(y, f.y1, 2 * (size_t)s->n * sizeof *y);
    }
    free_room(&f);
    return outcome;
}
