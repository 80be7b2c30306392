/* The instants at which event indicators of a scene come to zero, along the record of a run (docs/theory, section 5.17).
 *
 * Beside the run, which does not know of it: a step that is not known to hold no event (steps/scene_events.c) is looked at in eighths, in states as accurate as the
 * run. An indicator comes to zero where it is not below any more. Between two looks it may come above zero and go back, or below and come back: there its rate
 * changes its sign. What is not a number counts as what was there before. Times are found to rounding. */
#include "interface/crossings.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "base/tolerances.h"
#include "hybrid/state.h"
#include "interface/joint_changes.h"
#include "steps/scene_events.h"

enum {
    BEFORE_MIDDLE = 3, /* other tries of a root, where they have not brought both ends nearer by half */
    TOO_FAR = 2        /* roundings of the time that Newton's method goes beyond */
};

/* What indicators are where one is looked at, at t */
struct seen {
    double t;
    double *value, *rate, *size; /* [indicators] */
};

/* What is known as far as has been looked; a leg of a run that halts, which is undone, puts it back */
struct known {
    struct seen last;
    unsigned char *looked; /* [indicators] whether each is looked for */
    unsigned char *below; /* [indicators][2] whether they have been below zero, beyond rounding, times 1 and times -1 */
    long *left;     /* [indicators] how many more of its events come until a run that halts does, -1: it does not; */
    long *came;     /* [indicators] how many of them have, of those that count */
    size_t count;   /* events that were found, */
    size_t counted; /* and of those, which count for where a run halts */
    size_t row;     /* the last row that was looked at, */
    size_t impact;  /* and how many impacts were */
    size_t first,
        done; /* of a run that has halted, the number of the first that came together with what it halted at; and how many there were then */
    int begun;
};

struct watch {
    struct known now, before_leg;
    struct between between;
    struct seen next, probe;
    unsigned char *before; /* now.below at the last look */
    size_t halted;         /* the number in `found` of the event at which a run that halts does */
    unsigned char *acts;   /* [indicators] whether each sets something, */
    double *y;             /* [2 n] a state */
    double *border;        /* [indicators] times at which they begin or end to have values */
    char *state;           /* of the run before such a leg */
    int probed;            /* one of which a root is looked for */
    double sign, level;    /* in that: times its value, less the level */
    int by_rate;           /* or times its rate */
    double rise;           /* the slope of that which is found */
    struct ccgen_crossing *found;
    double *states;       /* [now.count][2 n] */
    double *since;        /* [now.count] when the look before each was, */
    double *slope;        /* [now.count] how fast each came to zero from there, on average; 0: by a jump */
    unsigned char *flags; /* [now.count][indicators][2] and now.below then */
    size_t room;
};

static int take_seen(struct arena *arena, int count, struct seen *one)
{
    one->value = TAKE_ZEROS(arena, double, count);
    one->rate = TAKE_ZEROS(arena, double, count);
    one->size = TAKE_ZEROS(arena, double, count);
    return arena->ran_out;
}

static int take_known(struct arena *arena, int count, struct known *one)
{
    one->looked = TAKE_ZEROS(arena, unsigned char, count);
    one->below = TAKE_ZEROS(arena, unsigned char, 2 * (size_t)count);
    one->left = TAKE_ZEROS(arena, long, count);
    one->came = TAKE_ZEROS(arena, long, count);
    return take_seen(arena, count, &one->last);
}

/* The arrays stay where they are. */
static void copy_known(size_t indicators, const struct known *from, struct known *to)
{
    const struct known arrays = *to;
    *to = *from;
    to->looked = arrays.looked;
    to->below = arrays.below;
    to->left = arrays.left;
    to->came = arrays.came;
    to->last = (struct seen){from->last.t, arrays.last.value, arrays.last.rate, arrays.last.size};
    memcpy(to->looked, from->looked, indicators);
    memcpy(to->below, from->below, 2 * indicators);
    memcpy(to->left, from->left, indicators * sizeof *to->left);
    memcpy(to->came, from->came, indicators * sizeof *to->came);
    memcpy(to->last.value, from->last.value, indicators * sizeof *to->last.value);
    memcpy(to->last.rate, from->last.rate, indicators * sizeof *to->last.rate);
    memcpy(to->last.size, from->last.size, indicators * sizeof *to->last.size);
}

int take_watch(struct ccgen_simulation *it)
{
    struct arena *arena = &it->arena;
    const int count = it->system.model->indicators;
    struct watch *w = it->watch = TAKE_ZEROS(arena, struct watch, 1);
    if (!w || take_between(it, &w->between))
        return 1;
    w->before = TAKE_ZEROS(arena, unsigned char, 2 * (size_t)count);
    w->acts = TAKE_ZEROS(arena, unsigned char, count);
    w->y = TAKE(arena, double, 2 * (size_t)it->system.n);
    w->border = TAKE_ZEROS(arena, double, count);
    w->state = TAKE(arena, char, kept_size(&it->phase));
    for (int j = 0; j < it->system.model->event_values && !arena->ran_out; j++)
        w->acts[it->system.model->value_of[j]] = 1;
    for (int i = 0; i < count && !arena->ran_out; i++)
        w->acts[i] |= is_of_joint(it, i) || (it->on_event && (!it->answered || it->answered[i]));
    return take_known(arena, count, &w->now) || take_known(arena, count, &w->before_leg) ||
           take_seen(arena, count, &w->next) || take_seen(arena, count, &w->probe);
}

/* After how many more of an event a run halts, -1: it does not */
static long how_many(const struct ccgen_simulation *it, int i)
{
    const struct watch *w = it->watch;
    const long more = it->system.model->stops_at[i] - w->now.came[i];
    return !it->run.acts || w->acts[i] ? 1 : more > 0 ? more : -1;
}

void free_watch(struct ccgen_simulation *it)
{
    if (!it->watch)
        return;
    free(it->watch->found);
    free(it->watch->states);
    free(it->watch->since);
    free(it->watch->slope);
    free(it->watch->flags);
}

static void see(const struct ccgen_simulation *it, double t, const double *q, const double *u, struct seen *to)
{
    const struct system *s = &it->system;
    const double scales[] = {s->length, s->time};
    to->t = t;
    s->model->indicate(s->k, q, u, t, scales, to->value, to->rate, to->size);
}

/* What has become one that is looked for: a force counts as one that was less before. */
static void look_for(struct ccgen_simulation *it)
{
    struct watch *w = it->watch;
    for (int i = 0; i < it->system.model->indicators; i++) {
        const unsigned char looked = (unsigned char)is_looked_for(it, i);
        if (looked && !w->now.looked[i])
            w->now.below[2 * i] = (unsigned char)is_of_force(it, i);
        w->now.looked[i] = looked;
    }
}

void begin_watch(struct ccgen_simulation *it)
{
    struct watch *w = it->watch;
    if (!w)
        return;
    w->now.begun = 0;
    w->now.row = w->now.count = w->now.counted = w->now.impact = 0;
    memset(w->now.looked, 0, it->system.model->indicators);
    memset(w->now.below, 0, 2 * (size_t)it->system.model->indicators);
    look_for(it);
    for (int i = 0; i < it->system.model->indicators; i++) {
        w->now.came[i] = 0;
        w->now.left[i] = how_many(it, i);
    }
    w->now.first = w->now.done = 0;
    it->broken_off = it->leg.goes_on = 0;
}

void watch_from_start(struct ccgen_simulation *it)
{
    struct watch *w = it->watch;
    const double *y = it->phase.y;
    begin_watch(it);
    if (!w)
        return;
    see(it, it->phase.t, y, y + it->system.n, &w->probe);
    for (int i = 0; i < it->system.model->indicators; i++)
        if (is_of_time(it, i) && !(w->probe.value[i] > 0.0))
            w->now.below[2 * i] = 1;
}

/* At a row as it is recorded: the end of a step, or what an impact leaves */
static enum outcome see_row(const struct ccgen_simulation *it, size_t row, struct seen *to)
{
    const struct record *record = &it->run.record;
    const double t = record->t[row], *y = record->y + row * (it->system.size + it->system.model->latches);
    const int before = row + 1 < record->count && record->t[row + 1] == t;
    see(it, t, y, y + it->system.n, to);
    return compare_forces(it, &it->watch->between, t, before, y, y + it->system.n, to->value);
}

static enum outcome look_at(struct ccgen_simulation *it, double t, struct seen *to)
{
    struct watch *w = it->watch;
    double *q = w->y, *u = q + it->system.n;
    const enum outcome outcome = state_at(it, &w->between, t, q, u);
    if (outcome)
        return outcome;
    see(it, t, q, u, to);
    return compare_forces(it, &w->between, t, 0, q, u, to->value);
}

/* What a root is looked for of, at t, and its rate, no number where that is not known */
static enum outcome probe(struct ccgen_simulation *it, double t, double *value, double *rate)
{
    struct watch *w = it->watch;
    const enum outcome outcome = look_at(it, t, &w->probe);
    const double known = w->sign * w->probe.rate[w->probed];
    *value = w->by_rate ? known : w->sign * w->probe.value[w->probed] - w->level;
    *rate = w->by_rate || !it->system.model->rated[w->probed] ? NAN : known;
    return outcome;
}

/* The instant, to rounding, at which what is probed, `low` < 0 at a, comes to zero, where it is `high` at *b: into *b, where it is not negative. By Newton's method, or, of what has no
 * known rate, by secants, a little too far, so that it comes from both sides; by bisection where that goes slowly. */
static enum outcome passage(struct ccgen_simulation *it, double a, double *b, double low, double high)
{
    double width = *b - a, last_t = a, last = low, t = *b - high * (*b - a) / (high - low);
    for (int tries = 0;; tries++) {
        const double middle = 0.5 * (a + *b);
        double value, rate;
        if (!(a < middle && middle < *b))
            return OUTCOME_DONE;
        const int slow = tries % (BEFORE_MIDDLE + 1) == BEFORE_MIDDLE && *b - a > 0.5 * width;
        if (tries % (BEFORE_MIDDLE + 1) == BEFORE_MIDDLE)
            width = *b - a;
        if (slow || !(a < t && t < *b))
            t = middle;
        const enum outcome outcome = probe(it, t, &value, &rate);
        if (outcome)
            return outcome;
        if (isnan(rate))
            rate = (value - last) / (t - last_t);
        last_t = t;
        last = value;
        if (!(value >= 0.0)) /* also where it is no number */
            a = t;
        else
            *b = t;
        t += -value / rate + (value < 0.0 ? TOO_FAR : -TOO_FAR) * DBL_EPSILON * fabs(t);
    }
}

/* What comes together with an impact comes at its instant. */
static double at_impact(const struct run *run, double t)
{
    const struct impacts *impacts = &run->impacts;
    double found = t, nearest = TOGETHER * fmax(fabs(t), run->duration);
    for (size_t k = impacts->count; k > 0 && impacts->t[k - 1] >= t - nearest; k--)
        if (fabs(impacts->t[k - 1] - t) <= nearest) {
            nearest = fabs(impacts->t[k - 1] - t);
            found = impacts->t[k - 1];
        }
    return found;
}

static enum outcome append(struct ccgen_simulation *it, double t, int indicator, int direction)
{
    struct watch *w = it->watch;
    const size_t width = 2 * (size_t)it->system.n, signals = 2 * (size_t)it->system.model->indicators;
    if (w->now.count == w->room) {
        const size_t room = w->room ? 2 * w->room : 16;
        struct ccgen_crossing *found = realloc(w->found, room * sizeof *found);
        w->found = found ? found : w->found;
        double *states = realloc(w->states, room * width * sizeof *states);
        w->states = states ? states : w->states;
        double *since = realloc(w->since, room * sizeof *since);
        w->since = since ? since : w->since;
        double *slope = realloc(w->slope, room * sizeof *slope);
        w->slope = slope ? slope : w->slope;
        unsigned char *flags = realloc(w->flags, room * signals);
        w->flags = flags ? flags : w->flags;
        if (!found || !states || !since || !slope || !flags)
            return OUTCOME_NO_MEMORY;
        w->room = room;
    }
    double *y = w->states + w->now.count * width;
    t = at_impact(&it->run, t);
    const enum outcome outcome = state_at(it, &w->between, t, y, y + it->system.n);
    w->since[w->now.count] = w->now.last.t;
    w->slope[w->now.count] = w->rise;
    memcpy(w->flags + w->now.count * signals, w->before, signals);
    if (!outcome && is_near(it, indicator, y))
        w->found[w->now.count++] = (struct ccgen_crossing){t, indicator, direction};
    return outcome;
}

/* What of the value of one is rounding; nothing where that has no bound, as where a root begins */
static double rounding_of(const struct seen *at, int i)
{
    const double zero = INDICATOR_ROUNDINGS * DBL_EPSILON * at->size[i];
    return isfinite(zero) ? zero : 0.0;
}

/* Whether one was below zero at a look, times `sign`; where it is no number, as `before` */
static int is_below(const struct seen *at, int i, double sign, int before)
{
    const double value = sign * at->value[i];
    return isnan(value) ? before : value < -rounding_of(at, i);
}

/* The event of one indicator, times `sign`, from the last look to the next, if there is one; in a piece of a step that is looked through, also one that is passed and passed back */
static enum outcome cross(struct ccgen_simulation *it, int i, double sign, int was, int is, int piece)
{
    struct watch *w = it->watch;
    const double zero = rounding_of(&w->now.last, i), first = sign * w->now.last.value[i];
    const double rates[] = {sign * w->now.last.rate[i], sign * w->next.rate[i]};
    const int valued = !isnan(first) && !isnan(w->next.value[i]); /* a rate there may be beside no value */
    const int apart = it->system.model->rated[i] && piece && valued && w->now.last.t < w->next.t;
    const int peak = apart && was && is && rates[0] > 0.0 && rates[1] < 0.0;
    const int dip = apart && first > 0.0 && sign * w->next.value[i] > 0.0 && rates[0] < 0.0 && rates[1] > 0.0;
    double a = w->now.last.t, b = w->next.t, low = first, high = sign * w->next.value[i];
    enum outcome outcome = OUTCOME_DONE;
    if (!(was && !is) && !peak && !dip)
        return outcome;
    w->probed = i;
    w->sign = sign;
    w->level = 0.0;
    if (peak || dip) { /* where it is farthest */
        double turn = b;
        w->by_rate = 1;
        w->sign = peak ? -sign : sign;
        outcome = passage(it, a, &turn, peak ? -rates[0] : rates[0], peak ? -rates[1] : rates[1]);
        w->by_rate = 0;
        w->sign = sign;
        *(peak ? &b : &a) = turn;
        double rate;
        outcome = outcome ? outcome : probe(it, turn, peak ? &high : &low, &rate);
        if (outcome || !(peak ? high >= -zero : low < -zero)) /* nor where it is no number */
            return outcome;
    }
    w->level = fmin(high, 0.0); /* where it only comes to zero as far as rounding tells */
    low -= w->level;
    high -= w->level;
    w->rise = a < b ? (high - low) / (b - a) : 0.0;
    if (a < b)
        outcome = passage(it, a, &b, low, high);
    outcome = outcome ? outcome : append(it, b, i, (int)sign);
    w->rise = 0.0;
    return outcome;
}

static void swap_numbers(size_t count, double *a, double *b)
{
    for (size_t i = 0; i < count; i++) {
        const double number = a[i];
        a[i] = b[i];
        b[i] = number;
    }
}

/* What came since the last look, which a piece of a step or quiet steps lie behind, in the order of time; the next look is then the last. */
static enum outcome compare(struct ccgen_simulation *it, int piece)
{
    struct watch *w = it->watch;
    const struct ccgen_model *m = it->system.model;
    const size_t before = w->now.count;
    enum outcome outcome = OUTCOME_DONE;
    memcpy(w->before, w->now.below, 2 * (size_t)m->indicators);
    for (int i = 0; i < m->indicators && !outcome; i++)
        for (int k = 0; k < 2 && !outcome; k++) {
            const double sign = k ? -1.0 : 1.0;
            unsigned char *below = &w->now.below[2 * i + k];
            if (!w->now.looked[i]) {
                *below = 0;
                continue;
            }
            const int is = is_below(&w->next, i, sign, *below);
            if (m->directions[i] != -(int)sign && w->now.begun)
                outcome = cross(it, i, sign, *below, is, piece);
            else if (m->directions[i] != -(int)sign && *below && !is)
                outcome = append(it, w->next.t, i, (int)sign);
            *below = (unsigned char)is;
        }
    const size_t width = 2 * (size_t)it->system.n;
    for (size_t k = before + 1; k < w->now.count && !outcome; k++) /* few, and all of one look */
        for (size_t j = k; j > before && w->found[j].t < w->found[j - 1].t; j--) {
            const struct ccgen_crossing one = w->found[j];
            w->found[j] = w->found[j - 1];
            w->found[j - 1] = one;
            swap_numbers(width, w->states + j * width, w->states + (j - 1) * width);
            swap_numbers(1, w->slope + j, w->slope + j - 1);
        }
    if (outcome) { /* as if it had not been looked at */
        memcpy(w->now.below, w->before, 2 * (size_t)m->indicators);
        w->now.count = before;
        return outcome;
    }
    const struct seen last = w->now.last;
    w->now.last = w->next;
    w->next = last;
    w->now.begun = 1;
    return outcome;
}

/* A look at a row that no step is looked through to */
static enum outcome look_at_row(struct ccgen_simulation *it, size_t row)
{
    const enum outcome outcome = see_row(it, row, &it->watch->next);
    return outcome ? outcome : compare(it, 0);
}

/* Joints whose limits the impulses of impacts up to t pass */
static enum outcome look_at_impacts(struct ccgen_simulation *it, double t)
{
    struct watch *w = it->watch;
    const struct impacts *impacts = &it->run.impacts;
    enum outcome outcome = OUTCOME_DONE;
    for (; w->now.impact < impacts->count && impacts->t[w->now.impact] <= t && !outcome; w->now.impact += !outcome)
        for (int i = 0; i < it->system.model->indicators && !outcome; i++) {
            const struct ccgen_crossing *last = w->now.count ? &w->found[w->now.count - 1] : NULL;
            const int known = last && last->indicator == i && last->t == impacts->t[w->now.impact];
            int passed = 0;
            outcome = find_impulse(it, w->now.impact, i, &passed);
            if (!outcome && passed && !known) {
                memcpy(w->before, w->now.below, 2 * (size_t)it->system.model->indicators);
                outcome = append(it, impacts->t[w->now.impact], i, 1);
            }
        }
    return outcome;
}

/* Where an indicator has a value at one of the last look and t alone: a time on that side of the border, and as far from it as its rounding, which has no bound there for
 * roots and logarithms, is still known to half its digits. */
static enum outcome find_border(struct ccgen_simulation *it, int i, double t, double near, double *border)
{
    struct watch *w = it->watch;
    const int before = isnan(w->now.last.value[i]);
    double a = w->now.last.t, b = t;
    enum outcome outcome = OUTCOME_DONE;
    while (!outcome && b - a > near) {
        const double middle = 0.5 * (a + b);
        if (!(a < middle && middle < b))
            break;
        outcome = look_at(it, middle, &w->probe);
        *(isnan(w->probe.value[i]) == before ? &a : &b) = middle;
    }
    *border = before ? b + near : a - near;
    return outcome;
}

/* Looks between the last one and the next, which is at t, at such times in their order; *some is whether there are any, and the next look is lost then. */
static enum outcome look_at_borders(struct ccgen_simulation *it, double t, int *some)
{
    struct watch *w = it->watch;
    const int count = it->system.model->indicators;
    const double near =
        fmax(CCGEN_ROOT_EPSILON * (t - w->now.last.t), 4.0 * DBL_EPSILON * fmax(fabs(t), fabs(w->now.last.t)));
    enum outcome outcome = OUTCOME_DONE;
    *some = 0;
    for (int i = 0; i < count && !outcome; i++) {
        w->border[i] = INFINITY;
        if (isnan(w->now.last.value[i]) == isnan(w->next.value[i]))
            continue;
        *some = 1;
        outcome = find_border(it, i, t, near, &w->border[i]);
    }
    while (*some && !outcome) {
        int first = 0;
        for (int i = 1; i < count; i++)
            if (w->border[i] < w->border[first])
                first = i;
        const double at = w->border[first];
        if (!(at < t))
            break;
        w->border[first] = INFINITY;
        if (!(w->now.last.t < at))
            continue;
        outcome = look_at(it, at, &w->next);
        outcome = outcome ? outcome : compare(it, 1);
    }
    return outcome;
}

/* The next look, at t, which is that of a row if there is one */
static enum outcome see_next(struct ccgen_simulation *it, double t, const size_t *row)
{
    struct seen *next = &it->watch->next;
    if (!row)
        return look_at(it, t, next);
    return see_row(it, *row, next);
}

/* Go on to it, behind a piece of a step that is looked through or quiet ones. */
static enum outcome look_on(struct ccgen_simulation *it, double t, const size_t *row, int piece)
{
    int borders = 0;
    enum outcome outcome = see_next(it, t, row);
    if (!outcome && piece)
        outcome = look_at_borders(it, t, &borders);
    if (!outcome && borders)
        outcome = see_next(it, t, row);
    return outcome ? outcome : compare(it, piece);
}

static enum outcome look_through_step(struct ccgen_simulation *it, size_t row, unsigned char parts)
{
    struct watch *w = it->watch;
    const size_t end = row + 1;
    const double t0 = it->run.record.t[row], t1 = it->run.record.t[end];
    enum outcome outcome = !w->now.begun || w->now.last.t < t0 ? look_at_row(it, row) : OUTCOME_DONE;
    for (int k = 1; k < EVENT_PARTS && !outcome; k++) {
        const double t = t0 + (t1 - t0) * k / EVENT_PARTS;
        const int behind = parts >> (k - 1) & 1;
        if (!(behind || parts >> k & 1) ||
            !(w->now.last.t < t && t < t1)) /* between quiet parts, or in a step of few roundings */
            continue;
        outcome = look_on(it, t, NULL, behind);
    }
    return outcome ? outcome : look_on(it, t1, &end, parts >> (EVENT_PARTS - 1) & 1);
}

char *begin_halting(struct ccgen_simulation *it)
{
    struct watch *w = it->watch;
    for (int i = 0; i < it->system.model->indicators; i++)
        if (!w->now.left[i] || it->run.acts)
            w->now.left[i] = how_many(it, i);
    return w->state;
}

/* The time of the first row that is not before t */
static double end_of_step(const struct record *record, double t)
{
    size_t row = record->count - 1;
    while (row && record->t[row - 1] >= t)
        row--;
    return record->t[row];
}

enum outcome find_halt(struct ccgen_simulation *it, struct halt *halt)
{
    struct watch *w = it->watch;
    const enum outcome outcome = find_crossings(it);
    while (w->now.counted < w->now.count && halt->indicator < 0) {
        const size_t k = w->now.counted++;
        long *left = &w->now.left[w->found[k].indicator];
        w->now.came[w->found[k].indicator]++;
        if (*left > 0 && --*left == 0) {
            const double t = w->found[k].t;
            w->halted = k;
            *halt = (struct halt){t, end_of_step(&it->run.record, t), w->found[k].indicator};
        }
    }
    return outcome;
}

void keep_watch(struct ccgen_simulation *it)
{
    copy_known(it->system.model->indicators, &it->watch->now, &it->watch->before_leg);
}

void restore_watch(struct ccgen_simulation *it)
{
    copy_known(it->system.model->indicators, &it->watch->before_leg, &it->watch->now);
}

double short_of_halt(struct ccgen_simulation *it)
{
    struct watch *w = it->watch;
    const struct ccgen_crossing *halt = &w->found[w->halted];
    const int i = halt->indicator;
    if (see_row(it, it->run.record.count - 1, &w->probe))
        return 0.0;
    for (size_t k = it->run.impacts.count;
         k > 0 && it->run.impacts.t[k - 1] == it->run.record.t[it->run.record.count - 1]; k--) {
        int passed = 0;
        if (find_impulse(it, k - 1, i, &passed) || passed)
            return 0.0;
    }
    if (!is_below(&w->probe, i, halt->direction, 0))
        return 0.0;
    const double value = w->probe.value[i], rate = w->probe.rate[i], rise = w->slope[w->halted];
    const double least = TOO_FAR * DBL_EPSILON * fabs(w->probe.t);
    double on = it->system.model->rated[i] ? -value / rate : NAN;
    if (!(on > 0.0 && on < INFINITY)) /* no rate is known, or one that leads back */
        on = fabs(value) / rise;
    return on > least && on < INFINITY ? on : least;
}

/* Of two that come at one instant: in the order of their tables, rises before falls */
static int comes_first(const struct ccgen_crossing *one, const struct ccgen_crossing *other)
{
    return one->indicator < other->indicator ||
           (one->indicator == other->indicator && one->direction > other->direction);
}

void end_at_halt(struct ccgen_simulation *it, double together)
{
    struct watch *w = it->watch;
    const struct record *record = &it->run.record;
    const size_t n = it->system.n, width = 2 * n;
    const double halt = w->found[w->halted].t;
    while (w->found[w->now.count - 1].t > halt + together)
        w->now.count--;
    for (; w->now.counted < w->now.count; w->now.counted++)
        w->now.came[w->found[w->now.counted].indicator]++;
    for (w->now.first = w->halted; w->now.first > w->now.done && w->found[w->now.first - 1].t >= halt - together;
         w->now.first--)
        ;
    w->now.done = w->now.count;
    w->now.row = record->count - 1;
    w->now.impact = it->run.impacts.count;
    for (size_t k = w->now.first; k < w->now.count; k++) {
        w->found[k].t = record->t[w->now.row];
        memcpy(w->states + k * width, record->y + w->now.row * (it->system.size + it->system.model->latches),
               width * sizeof *w->states);
    }
    see_row(it, w->now.row, &w->now.last);
    /* what was below zero before and has not come is to come, though it be zero now */
    const size_t signals = 2 * (size_t)it->system.model->indicators;
    unsigned char *flags = w->flags + w->halted * signals;
    for (size_t k = 0; k < w->now.count; k++)
        if (w->since[k] >= w->since[w->halted]) /* in the same piece, or together with it behind an impact */
            flags[2 * w->found[k].indicator + (w->found[k].direction < 0)] = 0;
    for (size_t k = 0; k < signals; k++) {
        const int i = (int)(k / 2);
        w->now.below[k] = (unsigned char)(is_below(&w->now.last, i, k % 2 ? -1.0 : 1.0, 0) || flags[k]);
    }
    for (size_t k = w->now.first + 1; k < w->now.count; k++) /* few, and in one state */
        for (size_t j = k; j > w->now.first && comes_first(&w->found[j], &w->found[j - 1]); j--) {
            const struct ccgen_crossing one = w->found[j];
            w->found[j] = w->found[j - 1];
            w->found[j - 1] = one;
        }
}

const struct ccgen_crossing *crossings_of_instant(const struct ccgen_simulation *it, size_t *first, size_t *count)
{
    const struct watch *w = it->watch;
    *first = w->now.first;
    *count = w->now.count - w->now.first;
    return w->found + w->now.first;
}

int stops_motion(struct ccgen_simulation *it, int indicator)
{
    struct watch *w = it->watch;
    const int stops_at = it->system.model->stops_at[indicator];
    if (!stops_at || w->now.came[indicator] < stops_at)
        return 0;
    w->now.came[indicator] = 0; /* who goes on counts from 1 */
    return 1;
}

void watch_anew(struct ccgen_simulation *it)
{
    it->watch->now.row = it->run.record.count - 1;
    it->watch->now.impact = it->run.impacts.count;
    it->watch->now.begun = 0;
    look_for(it);
}

int ccgen_crossings(struct ccgen_simulation *it, size_t *count, const struct ccgen_crossing **crossings,
                    const double **states)
{
    enum outcome outcome = it->run.tells ? OUTCOME_DONE : OUTCOME_BAD_SETTINGS;
    if (it->watch)
        outcome = look_at_all(it);
    *count = it->watch ? it->watch->now.count : 0;
    *crossings = *count ? it->watch->found : NULL;
    *states = *count ? it->watch->states : NULL;
    return outcome;
}

enum outcome look_at_all(struct ccgen_simulation *it)
{
    if (it->run.interruption.ended) /* of a run that was interrupted, what is recorded is looked at whole */
        start_asking(&it->run.interruption, it->phase.t);
    return find_crossings(it);
}

void forget_rows_looked_at(struct ccgen_simulation *it)
{
    if (it->watch)
        it->watch->now.row = it->watch->now.impact = 0;
}

enum outcome find_crossings(struct ccgen_simulation *it)
{
    struct watch *w = it->watch;
    const struct record *record = &it->run.record;
    const size_t rows = record->count;
    enum outcome outcome = rows ? OUTCOME_DONE : OUTCOME_NOT_BEGUN;
    if (!outcome && !w->now.begun)
        outcome = look_at_row(it, w->now.row);
    while (!outcome && w->now.row + 1 < rows) {
        const size_t row = w->now.row, next = row + 1;
        const double t = record->t[row], then = record->t[next];
        const int last = next + 1 == rows || record->t[next + 1] > then; /* of its time */
        if (interrupted(&it->run.interruption, 0))
            return OUTCOME_INTERRUPTED;
        if (then > t)
            outcome = record->events[next] ? look_through_step(it, row, record->events[next]) : OUTCOME_DONE;
        else if (w->now.last.t < t) /* before an impact, behind a quiet step */
            outcome = look_at_row(it, row);
        if (!outcome && !(then > t) && last)
            outcome = look_at_row(it, next);
        if (!outcome && last)
            outcome = look_at_impacts(it, then);
        w->now.row += !outcome;
    }
    return outcome;
}
