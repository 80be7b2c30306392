/* The hybrid run: flight until an event or the end, impact at the event, flight again. */
#include "run.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "events.h"

static const double SAFETY = 0.9, LEAST_CHANGE = 0.2, LARGEST_CHANGE = 6.0;
static const double REST_SPEED = 1e-10;       /* times length per second: a contact this slow does not bounce */
static const double ACCUMULATION_REST = 1e-9; /* s left until impacts accumulate, relative to max(1, t) */
enum {
    LANDINGS = 12, /* steps towards an event */
    REPEATS = 100, /* impacts at one instant */
    ALIKE = 5,     /* intervals in steady proportion before impacts are said to accumulate */
    CROWD = 40,    /* events within the time that counts as none */
    TICK = 64      /* steps between looks at the outside world */
};

/* How the impacts of one contact follow each other. */
struct history {
    double t, interval, ratio;
    int alike; /* consecutive intervals that shrink by about the same ratio */
};

struct flight {
    struct system *s;
    struct run *run;
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
    const double h0 = d0 < 1e-5 || d1 < 1e-5 ? 1e-6 : 0.01 * d0 / d1;
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
    return fmin(100.0 * h0, h1);
}

/* Step of length h from (t, y) to y1, put back onto the closure unless its error is refused anyway. */
static enum outcome projected_step(struct flight *f, double h, double *error)
{
    const struct run *run = f->run;
    enum outcome outcome = run->method->step(f->s, f->scratch, f->t, h, f->y, f->dy, run->tolerance, f->y1, error);
    if (run->fixed_step > 0.0)
        *error = 0.0;
    if (!outcome && *error <= 1.0 && !(outcome = project_position(f->s, f->y1)))
        outcome = project_velocity(f->s, f->y1, f->y1 + f->s->n);
    return outcome;
}

/* Step until the error test passes; the step's length is in f->h before and after, `next` is the one to try then. */
static enum outcome accepted_step(struct flight *f, double *next)
{
    struct run *run = f->run;
    const double least = 16.0 * DBL_EPSILON * fmax(fabs(f->t), 1e-3);
    int refused = 0;
    for (;;) {
        double error = 0.0;
        enum outcome outcome = projected_step(f, f->h, &error);
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

/* Step again from (t, y) so that the step ends at the event; y1 is then the state there, as accurate as any step's end. */
static enum outcome land(struct flight *f, struct event event)
{
    const struct ccgen_model *m = f->s->model;
    double h = event.theta * f->h;
    for (int i = 0; i < LANDINGS; i++) {
        double error = 0.0;
        if (f->t + h <= f->t) { /* the event is where the step begins */
            memcpy(f->y1, f->y, 2 * f->s->n * sizeof *f->y);
            h = 0.0;
            break;
        }
        enum outcome outcome = projected_step(f, h, &error);
        if (outcome)
            return outcome;
        m->gaps(f->s->k, f->y1, f->gaps);
        m->gap_rates(f->s->k, f->y1, f->y1 + f->s->n, f->rates);
        const double g = f->gaps[event.contact], rate = f->rates[event.contact];
        const double change = rate < 0.0 ? -g / rate : 0.0;
        if (fabs(change) <= DBL_EPSILON * fmax(f->t + h, f->h))
            break;
        h = fmin(fmax(h + change, 0.0), f->h);
    }
    f->h = h;
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
    const int n = 2 * f->s->n;
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
        f->h = last ? run->until - f->t : wanted;
        const double asked = f->h;
        if ((outcome = accepted_step(f, &next)))
            break;
        if (f->s->model->contacts) {
            if ((outcome = system_derivative(f->s, f->t + f->h, f->y1, f->dy1)) ||
                (outcome = run->method->prepare(f->s, f->scratch, f->t, f->h, f->y, f->dy, f->y1, f->dy1)))
                break;
            const struct event event = find_event(f->s, run->method, f->scratch, slow(f), f->search);
            if (event.contact >= 0) {
                if (last)
                    next = fmax(next, wanted);
                if ((outcome = land(f, event)))
                    break;
                f->t += f->h;
                memcpy(f->y, f->y1, n * sizeof *f->y);
                f->h = next;
                *contact = event.contact;
                return OUTCOME_DONE;
            }
        } else if ((outcome = system_derivative(f->s, f->t + f->h, f->y1, f->dy1)))
            break;
        if (last)
            next = fmax(next, wanted);
        f->t = last && f->h == asked ? run->until : f->t + f->h;
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

/* Note an impact of a contact; nonzero when its impacts accumulate: intervals shrink by a steady ratio and hardly any time
 * is left to their limit. */
static int accumulates(struct flight *f, int contact)
{
    struct history *past = &f->history[contact];
    const double interval = f->t - past->t, ratio = past->interval > 0.0 ? interval / past->interval : 0.0;
    const int steady = ratio > 0.0 && ratio < 1.0 && fabs(ratio - past->ratio) <= 0.05 * ratio;
    past->alike = steady ? past->alike + 1 : 0;
    past->t = f->t;
    past->interval = interval;
    past->ratio = ratio;
    const double rest = steady ? interval * ratio / (1.0 - ratio) : INFINITY;
    if (past->alike < ALIKE || rest > ACCUMULATION_REST * fmax(1.0, fabs(f->t)))
        return 0;
    f->run->accumulation = f->t + rest;
    f->run->contact = contact;
    return 1;
}

/* Whether a contact that neither opens nor closes is pressed shut: its gap accelerates inwards. */
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
    return rate[1] < rate[0];
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
    run->contact = resting(f, closed, still);
    return run->contact >= 0 ? OUTCOME_SUSTAINED : OUTCOME_DONE;
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
    double *block = malloc((4 * n + scratch + n + 5 * c + 4 * c + 1) * sizeof *block);
    f->set = malloc((c + 1) * sizeof *f->set);
    f->history = calloc(c + 1, sizeof *f->history);
    f->y = block;
    if (!block || !f->set || !f->history)
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

void simulate(struct system *s, struct run *run, double *y)
{
    struct flight f = {.s = s, .run = run, .t = run->start};
    run->contact = -1;
    run->outcome = OUTCOME_NO_MEMORY;
    double *block = NULL;
    if (!make_room(&f)) {
        block = f.y;
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
    free(block);
    free(f.set);
    free(f.history);
}

enum outcome advance(struct system *s, const struct method *method, double t, double h, double *y)
{
    struct run run = {.method = method, .tolerance = {1.0, 1.0}, .fixed_step = h};
    struct flight f = {.s = s, .run = &run, .t = t};
    if (make_room(&f)) {
        free(f.y);
        free(f.set);
        free(f.history);
        return OUTCOME_NO_MEMORY;
    }
    double *block = f.y, error = 0.0;
    memcpy(f.y, y, 2 * (size_t)s->n * sizeof *y);
    enum outcome outcome = derive(&f);
    if (!outcome && !(outcome = projected_step(&f, h, &error)))
        memcpy(y, f.y1, 2 * (size_t)s->n * sizeof *y);
    free(block);
    free(f.set);
    free(f.history);
    return outcome;
}
