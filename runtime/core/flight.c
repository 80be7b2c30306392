/* Flight: steps with their error estimates, and the search for events. */
#include "flight.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "keeping.h"
#include "landing.h"
#include "passing.h"
#include "resolution.h"

extern const struct method gauss; /* by which steps pass singular configurations */

static const double SAFETY = 0.9, LEAST_CHANGE = 0.2, LARGEST_CHANGE = 6.0;
static const struct tolerance TO_ROUNDING = {0.0, 0.0};
static const double UNEVEN = 1e-3;          /* of the tolerance: what iterations may leave that do not go to rounding */
static const double EARLY = 0.05;           /* part of a step: events before it are looked for in a shorter step */
static const double LONGEST_REBOUND = 10.0; /* times the flight before an impact: the first step tried after it */
static const double BELIEVED = 0.1; /* of an error is there, whatever of it lies across the closure: steps are a third longer at most */
static const double CRAWL = CCGEN_LIMIT(1e-8, 1e-4); /* rad, and times length: what is unknown near a line of links */
static const double REST_SPEED = 1e-10;     /* times extent per second: a contact this slow does not bounce */
static const double ADRIFT = 1e-11;         /* times extent: the gap of a carried contact that is not closed any more */
static const double LEAP = 1e-6, FURTHER = 10.0; /* rad, or times length; times the way that velocities carry */
static const double DRIVEN = CCGEN_LIMIT(1e-8, 1e-3); /* rad and rad/s, or m: more is not the rounding of a driven joint */
enum {
    SHORTER = 60,  /* shorter steps in search of an early event */
    AGAIN = 4,     /* times a step is taken anew for where it passes a singular configuration */
    CRAWLS = 20,   /* steps in a row that move nothing, before what they might be stuck at is looked at */
    TICK = 64      /* short steps between two questions whether to go on */
};

/* speed (m/s, rad/s) below which a closed contact neither opens nor closes */
double slow(const struct flight *f, int contact)
{
    return REST_SPEED * f->s->extent[contact];
}

double near(const struct flight *f, int contact)
{
    return fmin(fmax(f->run->tolerance.rtol, 1e-12), 1e-8) * f->s->extent[contact];
}

enum outcome derive(struct flight *f)
{
    return system_derivative(f->s, f->t, f->y, f->dy);
}

/* First step size by comparing an Euler step with its derivative (Hairer, Norsett, Wanner 1993, section II.4). */
static double first_step(struct flight *f)
{
    const int n = f->s->size;
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
    const double h0 = fmin(d0 < 1e-5 || d1 < 1e-5 ? 1e-6 : fmax(0.01 * d0 / d1, least), f->run->until - f->t);
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

int projects(const struct flight *f)
{
    return holds(f->s) || (f->s->model->rows && f->run->drift == DRIFT_PROJECTED);
}

/* Where driven joint d is or, of velocities x, how fast it moves */
static double driven(const struct ccgen_model *m, int d, const double *x)
{
    const int second = m->driven[2 * d + 1];
    return x[m->driven[2 * d]] - (second < 0 ? 0.0 : x[second]);
}

/* Put the end of a step back onto the closure and the held contacts. Driven joints stay as prescribed: where the loops close
 * only without that, as beyond a dead point, they do not close. */
static enum outcome project_end(struct flight *f)
{
    const struct ccgen_model *m = f->s->model;
    const int n = f->s->n;
    if (!projects(f))
        return OUTCOME_DONE;
    double *place = f->search, *speed = place + m->drives, fast = 1.0;
    for (int d = 0; d < m->drives; d++) {
        place[d] = driven(m, d, f->y1);
        speed[d] = driven(m, d, f->y1 + n);
        fast = fmax(fast, fabs(speed[d]));
    }
    enum outcome outcome = project_position(f->s, f->y1);
    outcome = outcome ? outcome : project_velocity(f->s, f->y1, f->y1 + n);
    for (int d = 0; d < m->drives && !outcome; d++)
        if (fabs(driven(m, d, f->y1) - place[d]) > DRIVEN * fmax(1.0, f->s->length) ||
            fabs(driven(m, d, f->y1 + n) - speed[d]) > DRIVEN * fast)
            outcome = OUTCOME_NOT_CLOSED;
    return outcome;
}

enum outcome raw_step(struct flight *f, double h, struct tolerance tolerance)
{
    const int across = f->passage == ACROSS, other = across && f->passing && !holds(f->s);
    f->by = other ? &gauss : f->run->method;
    f->steps = other ? f->passing : f->scratch;
    if (other) {
        gauss.restart(f->passing, f->s->size);
        if (f->run->method->restart)
            f->run->method->restart(f->scratch, f->s->size);
    }
    f->s->guided = across;
    const enum outcome outcome = f->by->step(f->s, f->steps, f->t, h, tolerance, f->y, f->dy, f->y1);
    f->s->guided = 0;
    return outcome;
}

/* Derivative at the end of the step, for methods that want it, or do after a step by another. */
static enum outcome derive_end(struct flight *f)
{
    return f->run->method->derivatives || f->by != f->run->method ? system_derivative(f->s, f->t + f->h, f->y1, f->dy1) : OUTCOME_DONE;
}

enum outcome measure(struct flight *f, double *error)
{
    const struct method *method = f->by;
    const int n = f->s->n, size = f->s->size;
    *error = method->measure(f->steps, size, f->run->tolerance, f->y, f->y1);
    if (!projects(f) || !f->s->model->rows || !(*error > 1.0 && isfinite(*error)))
        return OUTCOME_DONE; /* across contacts alone an error is one: one that is passed may have jumped */
    int count;
    double *estimates = method->estimates(f->steps, size, &count);
    for (int i = 0; i < 2 * count; i++) { /* of the coordinates, then of the velocities */
        const enum outcome outcome = project_velocity(f->s, f->y1, estimates + (size_t)(i / 2) * size + i % 2 * n);
        if (outcome)
            return outcome;
    }
    const double left = f->passage == ACROSS ? 0.0 : BELIEVED * *error;
    *error = fmax(left, method->measure(f->steps, size, f->run->tolerance, f->y, f->y1));
    return OUTCOME_DONE;
}

/* Step of length h, put back onto the closure whatever its error. What a method iterates goes to rounding, so that y1 is a smooth
 * function of h: landing on an event needs that. */
enum outcome plain_step(struct flight *f, double h)
{
    const struct tolerance tolerance = f->run->tolerance, little = {UNEVEN * tolerance.atol, UNEVEN * tolerance.rtol};
    enum outcome outcome = raw_step(f, h, TO_ROUNDING);
    if (outcome == OUTCOME_NO_CONVERGENCE && little.rtol > 0.0) { /* loads that all but cancel have a rounding of their own */
        double error = INFINITY;
        outcome = raw_step(f, h, little);
        outcome = outcome ? outcome : measure(f, &error);
        outcome = outcome || error <= 1.0 ? outcome : OUTCOME_NO_CONVERGENCE;
    }
    return outcome ? outcome : project_end(f);
}

/* Whether the step has gone further than its velocities carry it: where the loops are all but flat, stages and projection may
 * find another way to close them, which the error across the closure, left out above, does not tell. */
static int leaps(const struct flight *f)
{
    double way = 0.0, speed = 0.0;
    for (int i = 0; i < f->s->n; i++) {
        way = fmax(way, fabs(f->y1[i] - f->y[i]));
        speed = fmax(speed, fmax(fabs(f->y[f->s->n + i]), fabs(f->y1[f->s->n + i])));
    }
    return f->run->fixed_step == 0.0 && way > FURTHER * f->h * speed + LEAP * fmax(1.0, f->s->length);
}

/* The shortest step that moves time */
static double shortest(const struct flight *f)
{
    return 16.0 * DBL_EPSILON * fmax(fabs(f->t), 1e-3);
}

/* Put the end of a step back. What it had been meanwhile is kept where its derivative will be. Whether the step is to be taken
 * again, because of the place at which it passes a singular configuration, in *again. */
static enum outcome put_back(struct flight *f, const double *error, int *again)
{
    double *end = f->dy1;
    memcpy(end, f->y1, (size_t)f->s->size * sizeof *end);
    const enum outcome back = project_end(f);
    *again = f->passage == FREE ? finds_singular(f, back, *error, end) : !back && *error <= 1.0 && misplaced(f, end);
    return *error <= 1.0 ? back : OUTCOME_DONE;
}

/* Step until the error test passes; the step's length is in f->h before and after, `next` is the one to try then. */
static enum outcome accepted_step(struct flight *f, double *next)
{
    struct run *run = f->run;
    int refused = 0, again = 0;
    for (;;) {
        double error = 0.0;
        const double whole = f->h;
        place_step(f);
        enum outcome outcome = raw_step(f, f->h, run->fixed_step > 0.0 ? TO_ROUNDING : run->tolerance);
        if (!outcome && run->fixed_step == 0.0)
            outcome = measure(f, &error);
        if (!outcome && isfinite(error)) {
            int anew;
            outcome = put_back(f, &error, &anew);
            if (anew && again++ < AGAIN) {
                if (f->passage == FREE)
                    f->own = whole * (error > 1.0 ? fmax(SAFETY * pow(error, -1.0 / f->by->order), LEAST_CHANGE) : 1.0);
                f->h = whole;
                continue;
            }
        }
        if (!outcome && error <= 1.0 && leaps(f))
            outcome = OUTCOME_NOT_CLOSED;
        if (!outcome && run->fixed_step > 0.0 && energy_lost(f))
            outcome = OUTCOME_NOT_KEPT;
        if (!outcome && error <= 1.0)
            error = fmax(error, energy_missed(f));
        if (!outcome && error <= 1.0) {
            const double change = SAFETY * pow(fmax(error, 1e-12), -1.0 / f->by->order);
            *next = f->h * fmin(fmax(change, LEAST_CHANGE), refused ? 1.0 : LARGEST_CHANGE);
            if (f->passage == BEFORE)
                *next = fmax(*next, whole);
            if (f->by != run->method) /* the length that the run's own method may have */
                *next = f->own;
            run->steps++;
            return OUTCOME_DONE;
        }
        if (outcome == OUTCOME_INTERRUPTED)
            return outcome;
        refused = 1;
        run->rejected++;
        const double change = outcome || !isfinite(error) ? LEAST_CHANGE : SAFETY * pow(error, -1.0 / f->by->order);
        f->h *= fmax(change, LEAST_CHANGE);
        if (f->h < shortest(f) || run->fixed_step > 0.0)
            return outcome ? outcome : OUTCOME_STEP_TOO_SMALL;
    }
}

/* Prepare the dense output of the step just taken and look for its first event. An event early in a long step is looked for
 * again in a shorter one, until it lies well inside: the dense output of a long step is too coarse for a short bounce. If a
 * shorter step turns out to have no event, it stands as the step taken. */
static enum outcome search_step(struct flight *f, struct event *event)
{
    for (int i = 0;; i++) {
        enum outcome outcome = derive_end(f);
        if (!outcome)
            outcome = f->by->prepare(f->s, f->steps, f->t, f->h, f->y, f->dy, f->y1, f->dy1);
        if (outcome)
            return outcome;
        *event = find_event(f->s, f->by, f->steps, f->t, f->h, REST_SPEED, f->search);
        const double shorter = 2.0 * event->theta * f->h;
        if (event->contact < 0 || event->theta > EARLY || f->t + shorter <= f->t || i == SHORTER)
            return OUTCOME_DONE;
        f->h = shorter;
        if ((outcome = plain_step(f, f->h)))
            return outcome;
    }
}

/* Whether a contact that others carry is not closed any more: what carries it has changed. */
static int lost(const struct flight *f)
{
    const struct ccgen_model *m = f->s->model;
    if (!f->s->holding || !f->s->holding->carried)
        return -1;
    m->gaps(f->s->k, f->y, f->gaps);
    for (int c = 0; c < m->contacts; c++)
        if (f->s->holding->closed[c] == CARRIED && fabs(f->gaps[c]) > ADRIFT * f->s->extent[c])
            return c;
    return -1;
}

/* A contact that is not held and has come to lie behind its surface, or deeper, at the end of the step, or -1: an event has
 * escaped */
static int inside(const struct flight *f)
{
    const struct ccgen_model *m = f->s->model;
    double *before = f->rates;
    if (!m->contacts)
        return -1;
    m->gaps(f->s->k, f->y, before);
    m->gaps(f->s->k, f->y1, f->gaps);
    for (int c = 0; c < m->contacts; c++)
        if (f->s->holding->closed[c] != HELD &&
            f->gaps[c] < fmin(-ADRIFT * f->s->extent[c], before[c] - DEEP * f->s->extent[c]))
            return c;
    return -1;
}

/* Whether the run has taken more steps and events than a simulated second may have */
static int crowded(struct run *run, double t)
{
    const long spent = run->steps + run->rejected + run->events;
    if (t >= run->second + 1.0) {
        run->second = t;
        run->spent_before = spent;
    }
    return run->fixed_step == 0.0 && spent - run->spent_before > run->second_budget;
}

/* Whether links have gone no further in the step than their places are known to near a line */
static int crawls(const struct flight *f)
{
    return f->s->model->contacts && f->s->model->rows && f->h * fastest(f->s, f->y + f->s->n) < CRAWL;
}

/* Record the present state, unless it is the last row already. */
int keep(struct flight *f)
{
    const struct record *r = &f->run->record;
    const size_t width = f->s->size;
    if (r->count && r->t[r->count - 1] == f->t && !memcmp(r->y + (r->count - 1) * width, f->y, width * sizeof *f->y))
        return 0;
    return append_row(&f->run->record, f->t, f->y, width);
}

double next_stop(const struct run *run, double t)
{
    size_t low = 0, high = run->stop_count; /* stops before low are not after t, those from high on are */
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (run->stops[middle] <= t)
            low = middle + 1;
        else
            high = middle;
    }
    return low < run->stop_count ? fmin(run->stops[low], run->until) : run->until;
}

enum outcome reach(struct flight *f, double until)
{
    double next = until - f->t;
    f->place = NAN;
    while (f->t < until) {
        const double left = until - f->t;
        f->h = 1.01 * next >= left ? left : next;
        const int last = f->bounded = f->h == left;
        enum outcome outcome = accepted_step(f, &next);
        if (outcome || (last && f->h == left))
            return outcome;
        if ((outcome = derive_end(f)))
            return outcome;
        f->t += f->h;
        memcpy(f->y, f->y1, (size_t)f->s->size * sizeof *f->y);
        memcpy(f->dy, f->dy1, (size_t)f->s->size * sizeof *f->dy);
    }
    return OUTCOME_DONE;
}

enum outcome fly(struct flight *f, struct event *event)
{
    struct run *run = f->run;
    const double since = f->t;
    enum outcome outcome = f->unresolved > 0.0 ? depart(f) : derive(f);
    event->contact = -1;
    f->energy_known = 0;
    f->place = NAN;
    if (run->method->restart)
        run->method->restart(f->scratch, f->s->size);
    if (!outcome && f->h <= 0.0)
        f->h = run->fixed_step > 0.0 ? run->fixed_step : first_step(f);
    int crawled = 0;
    double next = f->h, late = 0.0; /* what rounding took from the time: many equal steps are as long as they say */
    while (!outcome && f->t < run->until) {
        run->interruption.t = f->t;
        if ((run->steps % TICK == 0 && ask(&run->interruption)) || interrupted(f->s, 0))
            return OUTCOME_INTERRUPTED;
        if (run->steps + run->rejected >= run->step_budget)
            return OUTCOME_BUDGET;
        if (crowded(run, f->t))
            return OUTCOME_CROWDED;
        const double wanted = run->fixed_step > 0.0 ? run->fixed_step : next;
        const double stop = next_stop(run, f->t);
        const int last = f->t + 1.01 * wanted >= stop;
        const double whole = last ? stop - f->t - late : wanted;
        f->h = whole;
        f->bounded = last;
        if ((outcome = accepted_step(f, &next)))
            break;
        if (last && f->h == whole)
            next = fmax(next, wanted);
        outcome = f->s->model->contacts ? search_step(f, event) : derive_end(f);
        if (!outcome && interrupted(f->s, 0)) /* what was found without accelerations is none */
            outcome = OUTCOME_INTERRUPTED;
        if (!outcome && event->contact >= 0)
            outcome = land(f, *event);
        if (!outcome && event->contact >= 0 && f->h > shortest(f) && leaps(f))
            outcome = OUTCOME_STEP_TOO_SMALL;
        if (!outcome && f->h != f->energy_h && f->h > shortest(f) && energy_missed(f) > 1.0) /* a shorter one than accepted */
            outcome = OUTCOME_STEP_TOO_SMALL;
        const int behind = outcome ? -1 : inside(f);
        if (behind >= 0 && (f->s->holding->closed[behind] == APART || f->h > shortest(f))) {
            run->contact = behind;
            outcome = OUTCOME_ESCAPED;
        }
        if (outcome && outcome != OUTCOME_INTERRUPTED && run->fixed_step == 0.0 && f->h > shortest(f)) {
            next = LEAST_CHANGE * f->h; /* no step ends there, or it ends too late: come nearer first */
            event->contact = -1;
            run->rejected++;
            outcome = OUTCOME_DONE;
            continue;
        }
        if (!outcome && event->contact >= 0) {
            f->t += f->h;
            memcpy(f->y, f->y1, (size_t)f->s->size * sizeof *f->y);
            f->h = fmin(next, LONGEST_REBOUND * (f->t - since));
            return OUTCOME_DONE;
        }
        if (outcome)
            break;
        energy_taken(f);
        const double step = f->h + late, then = last && f->h == whole ? stop : f->t + step;
        late = then == stop ? 0.0 : step - (then - f->t);
        f->t = then;
        double *swap = f->y;
        f->y = f->y1;
        f->y1 = swap;
        swap = f->dy;
        f->dy = f->dy1;
        f->dy1 = swap;
        if (keep(f))
            return OUTCOME_NO_MEMORY;
        if ((event->contact = lost(f)) >= 0) {
            event->watch = LOST;
            break;
        }
        int closed = 0;
        crawled = crawls(f) ? crawled + 1 : 0;
        if (crawled && crawled % CRAWLS == 0)
            outcome = close_unresolved(f, 1, &closed);
        if (closed) {
            *event = (struct event){f->set[0], 1.0, FLAT, 1.0};
            break;
        }
    }
    f->h = next;
    return outcome;
}
