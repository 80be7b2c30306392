/* The hybrid run: flight until an event or the end, impact at the event, flight again. */
#include "run.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "flight.h"

static const double REST_ACCELERATION = 1e-6; /* times length per second squared: a gap this slow is not pressed shut */
static const double ACCUMULATION_REST = 1e-9; /* s left until impacts accumulate, relative to max(1, t) */
enum {
    REPEATS = 100, /* impacts at one instant */
    ALIKE = 5,     /* intervals in steady proportion before impacts are said to accumulate */
    CROWD = 40     /* events within the time that counts as none */
};

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
    const size_t n = f->s->size, c = f->s->model->contacts, scratch = f->run->method->scratch((int)n);
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
        memcpy(f.y, y, (size_t)s->size * sizeof *y);
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
        memcpy(f.y, y, (size_t)s->size * sizeof *y);
        outcome = derive(&f);
        if (!outcome && !(outcome = plain_step(&f, h)))
            memcpy(y, f.y1, (size_t)s->size * sizeof *y);
    }
    free_room(&f);
    return outcome;
}
