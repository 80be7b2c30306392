/* One-sided event search on the dense output of a step.
 *
 * The step is looked at through SAMPLES pieces, or more where links turn far in it, as in a steady rotation. Within a piece
 * the gap of a contact and its rate at both ends tell what can happen: it crosses zero, or falls and rises again with its
 * least value inside, or is closed at first, opens, and closes. Extrema are roots of the rate, so a dip is found however
 * short it is against the piece. More than one extremum in a piece is told by the cubic through the ends of two pieces, which then
 * misses what was sampled between them: such pieces are halved until it does not, where the gap may come to zero.
 */
#include "steps/event_search.h"

#include <float.h>
#include <limits.h>
#include <math.h>
#include <string.h>

#include "base/tolerances.h"
#include "motion/sides.h"
#include "motion/switching.h"
#include "model/contacts.h"

static const double WINDOW_GROWTH =
    6.0; /* how much longer than the last a first window may be: as much as steps grow */
enum { SAMPLES = 8, ITERATIONS = 100, HALVINGS = 40, DIPS = 12, CLOSER = 12 };
enum { WATCHED_MOST = 3 /* values of a held contact: its force, and two of its friction where it sticks */ };

/* 128 times what the samples 1, 3, 5 and 7 are if a polynomial of degree 4 goes through 0, 2, 4, 6 and 8 */
static const double BETWEEN[4][5] = {
    {35, 140, -70, 28, -5}, {-5, 60, 90, -20, 3}, {3, -20, 90, 60, -5}, {-5, 28, -70, 140, 35}};

/* All gaps and their rates at a part of the step, or all watched values of effects and their slopes over it */
struct sampled {
    double theta;
    double *value, *rate; /* [sampled_count] */
};

struct search {
    struct system *s;
    const struct method *method;
    const double *steps;
    double t, h;
    double *y, *dy;                                   /* [size] at a sample */
    double *values;                                   /* [all] all gaps, rates or watched values there */
    void (*watch)(struct search *, double, double *); /* all watched values at a part of the step */
    double *velocities;                               /* [links][3] */
    /* what is sampled at a part of the step, and its first event between two samples */
    void (*take_sample)(struct search *, double, struct sampled *);
    struct event (*first_in_piece)(struct search *, const struct sampled *, const struct sampled *);
    int sampled_count;
    double span;                    /* of the step in the unit of rates */
    struct sampled ends[3];         /* of two pieces in a row */
    struct sampled between[CLOSER]; /* of pieces that are parted, so many times */
    double *samples;                /* [SAMPLES + 1][watched] watched values in a window */
    double *noise;                  /* [switches] what those of effects are known to */
    double slow;                    /* times extent: a closed contact is not falling before its rate is beyond this */
    int bears;                      /* whether events are asked for of contacts that come to bear in place of others */
    long interval_count;
};

/* all gaps (or their rates) at theta */
static void sample(struct search *search, double theta, double *gaps, double *rates)
{
    search->method->interpolate(search->steps, search->s->size, theta, search->y);
    if (gaps)
        contact_gaps(search->s, search->y, gaps);
    if (rates)
        contact_rates(search->s, search->y, search->y + search->s->n, rates);
}

static double gap(struct search *search, int contact, double theta)
{
    sample(search, theta, search->values, NULL);
    return search->values[contact];
}

static double rate(struct search *search, int contact, double theta)
{
    sample(search, theta, NULL, search->values);
    return search->values[contact];
}

/* Pieces in which to look at the step, an even number: gaps come and go with every turn of a link, however long the step */
static long interval_count(struct search *search)
{
    double *velocities = search->velocities;
    const struct ccgen_model *m = search->s->model;
    double low = 0.0, high = 0.0;
    for (int end = 0; end < 2; end++) {
        search->method->interpolate(search->steps, search->s->size, end, search->y);
        m->velocities(search->s->k, search->y, search->y + search->s->n, velocities);
        for (int i = 0; i < m->links; i++) {
            low = fmin(low, velocities[3 * i + 2]);
            high = fmax(high, velocities[3 * i + 2]);
        }
    }
    const double wanted = (high - low) * search->h / TURN;
    return wanted > SAMPLES && wanted < LONG_MAX / 2 ? 2 * ((long)wanted / 2 + 1) : SAMPLES;
}

/* the watched values of held contacts at theta; what cannot be computed counts as lost */
static void watch_contacts(struct search *search, double theta, double *values)
{
    struct system *s = search->s;
    search->method->interpolate(search->steps, s->size, theta, search->y);
    if (switching_functions(s, search->t + theta * search->h, search->y, search->dy, values))
        for (int i = 0; i < switching_count(s); i++)
            values[i] = -1.0;
}

/* and of effects with kinks */
static void watch_effects(struct search *search, double theta, double *values)
{
    struct system *s = search->s;
    search->method->interpolate(search->steps, s->size, theta, search->y);
    if (side_functions(s, search->t + theta * search->h, search->y, s->sides, values))
        for (int i = 0; i < s->model->switches; i++)
            values[i] = -1.0;
}

static double one_watched(struct search *search, int index, double theta)
{
    search->watch(search, theta, search->values);
    return search->values[index];
}

/* Root of f between a and b, where it has the signs of fa and fb: false position with the Illinois modification, and
 * bisection whenever a step shrinks the bracket by less than half in three. The returned end is the one with fb's sign. */
static double root(struct search *search, double (*f)(struct search *, int, double), int contact, double a, double fa,
                   double b, double fb)
{
    double width = fabs(b - a);
    for (int i = 0; i < ITERATIONS && fabs(b - a) > 1e-15; i++) {
        double c = b - fb * (b - a) / (fb - fa);
        if (i % 3 == 2) {
            if (fabs(b - a) > 0.5 * width)
                c = 0.5 * (a + b);
            width = fabs(b - a);
        }
        if (!((c > a && c < b) || (c > b && c < a)))
            c = 0.5 * (a + b);
        if (c == a || c == b)
            break;
        const double fc = f(search, contact, c);
        if ((fc < 0.0) == (fb < 0.0)) {
            b = c;
            fb = fc;
            fa *= 0.5;
        } else {
            a = c;
            fa = fc;
            fb *= 0.5;
        }
    }
    return b;
}

/* First event of one contact between theta a and b, or 2 when there is none. */
static double first_event_in_interval(struct search *search, int contact, double a, double ga, double ra, double b,
                                      double gb, double rb)
{
    const double extent = search->s->extent[contact], slow = search->slow * extent;
    if (ga <= 0.0 || (ga <= SHUT * extent && fabs(ra) <= slow)) {
        if (ra < -slow)
            return a;
        if (gb > 0.0 || rb >= 0.0) /* it opens, or is closed throughout and falls at neither end */
            return 2.0;
        const double start = a;
        for (int i = 0; i < HALVINGS && ra <= 0.0; i++) { /* at rest at first: does it open before it falls? */
            a = start + ldexp(b - start, -i - 1);
            ra = rate(search, contact, a);
        }
        if (ra <= 0.0)
            return start;
        const double top = root(search, rate, contact, a, ra, b, rb);
        const double highest = gap(search, contact, top);
        return highest > 0.0 ? root(search, gap, contact, top, highest, b, gb) : top;
    }
    if (gb <= 0.0 && ra > 0.0 &&
        rb < 0.0) { /* it rises first: past the top there is one entry, and no rounding near a */
        const double top = root(search, rate, contact, a, ra, b, rb);
        const double highest = gap(search, contact, top);
        return highest > 0.0 ? root(search, gap, contact, top, highest, b, gb < 0.0 ? gb : -DBL_MIN) : top;
    }
    if (gb <= 0.0)
        return root(search, gap, contact, a, ga, b, gb < 0.0 ? gb : -DBL_MIN);
    if (ra < 0.0 && rb > 0.0) {
        const double bottom = root(search, rate, contact, a, ra, b, rb);
        const double lowest = gap(search, contact, bottom);
        if (lowest <= 0.0)
            return root(search, gap, contact, a, ga, bottom, lowest < 0.0 ? lowest : -DBL_MIN);
    }
    return 2.0;
}

static void sample_gaps(struct search *search, double theta, struct sampled *at)
{
    sample(search, theta, at->value, at->rate);
}

/* Slopes over theta from differences over a millionth of a piece */
static void sample_effects(struct search *search, double theta, struct sampled *at)
{
    const double step = SLOPE / (double)search->interval_count, way = theta < 1.0 - step ? step : -step;
    watch_effects(search, theta + way, at->rate);
    watch_effects(search, theta, at->value);
    for (int i = 0; i < search->sampled_count; i++)
        at->rate[i] = (at->rate[i] - at->value[i]) / way;
}

/* A contact that is held does not close. */
static int is_held(const struct search *search, int contact)
{
    const struct active_set *h = search->s->active;
    return !search->noise && h && h->closed[contact];
}

/* The middle control point of the cubic with these values and slopes at the ends of a piece, raised to degree four: what the
 * cubic misses, which vanishes twice at either end, goes as 16 x^2 (1 - x)^2, and that is 8/3 of the middle one alone. */
static double middle_of_cubic(double ga, double ra, double gb, double rb, double width)
{
    return 0.5 * (ga + gb + width * (ra - rb) / 3.0);
}

/* Whether value i may come to zero unseen in the two pieces from a to m to b: what the cubic through a and b misses at m, in
 * value and slope, could bring that of a piece to zero. */
static int is_unresolved(const struct search *search, int i, const struct sampled *a, const struct sampled *m,
                         const struct sampled *b)
{
    const double first = (m->theta - a->theta) * search->span, second = (b->theta - m->theta) * search->span;
    const double width = first + second, x = first / width, y = 1.0 - x;
    const double va = a->value[i], vm = m->value[i], vb = b->value[i], ra = a->rate[i], rm = m->rate[i],
                 rb = b->rate[i];
    const double off =
        vm - y * y * (1.0 + 2.0 * x) * va - x * x * (1.0 + 2.0 * y) * vb - width * x * y * (y * ra - x * rb);
    const double slope_off =
        width * (rm - y * (1.0 - 3.0 * x) * ra - x * (1.0 - 3.0 * y) * rb) - 6.0 * x * y * (vb - va);
    const double wrong = fmax(fabs(off), 0.25 * fabs(slope_off));
    const double noise = search->noise ? search->noise[i] / SLOPE /* of slopes from differences */
                                       : SHUT * search->s->extent[i];
    const double low =
        fmin(fabs(middle_of_cubic(va, ra, vm, rm, first)), fabs(middle_of_cubic(vm, rm, vb, rb, second)));
    return wrong > noise && low < 32.0 * wrong;
}

/* First event of the gaps of contacts that are not held between two samples */
static struct event first_closing(struct search *search, const struct sampled *a, const struct sampled *b)
{
    struct event first = {-1, 2.0, CLOSES, 1.0};
    for (int c = 0; c < search->sampled_count; c++) {
        if (is_held(search, c))
            continue;
        const double theta =
            first_event_in_interval(search, c, a->theta, a->value[c], a->rate[c], b->theta, b->value[c], b->rate[c]);
        if (theta < first.theta)
            first = (struct event){c, theta, CLOSES, 1.0};
    }
    return first;
}

/* Where a piece from a to b is parted: by the golden section, since no period of a gap comes to all samples in the same phase then */
static double parted(double a, double b)
{
    return a + 0.3819660112501051 * (b - a);
}

/* First event in two pieces in a row, which are parted where that shows more; its place is 2 where there is none */
static struct event first_in_pair(struct search *search, const struct sampled *a, const struct sampled *m,
                                  const struct sampled *b, int level)
{
    int resolved = 1;
    for (int i = 0; i < search->sampled_count && level < CLOSER && resolved; i++)
        resolved = is_held(search, i) || !is_unresolved(search, i, a, m, b);
    if (resolved) {
        const struct event first = search->first_in_piece(search, a, m);
        return first.theta <= 1.0 ? first : search->first_in_piece(search, m, b);
    }
    struct sampled *between = &search->between[level];
    between->theta = parted(a->theta, m->theta);
    search->take_sample(search, between->theta, between);
    const struct event first = first_in_pair(search, a, between, m, level + 1);
    if (first.theta <= 1.0)
        return first;
    between->theta = parted(m->theta, b->theta);
    search->take_sample(search, between->theta, between);
    return first_in_pair(search, m, between, b, level + 1);
}

/* First event of what is sampled in the step */
static struct event first_sampled(struct search *search)
{
    struct event first = {-1, 2.0, CLOSES, 1.0};
    struct sampled *a = &search->ends[0], *m = &search->ends[1], *b = &search->ends[2];
    const double whole = (double)search->interval_count;
    a->theta = 0.0;
    search->take_sample(search, a->theta, a);
    for (long i = 0; i < search->interval_count && first.theta > 1.0 &&
                     !interrupted(search->s->interruption, search->sampled_count);
         i += 2) {
        b->theta = ((double)i + 2.0) / whole;
        m->theta = parted(a->theta, b->theta);
        search->take_sample(search, m->theta, m);
        search->take_sample(search, b->theta, b);
        first = first_in_pair(search, a, m, b, 0);
        struct sampled *swap = a;
        a = b;
        b = swap;
    }
    return first;
}

int falls_from_zero(double value, double at_twice)
{
    return value < 0.0 && value <= FALLING * at_twice;
}

/* Event of a watched value that is lost at theta b. A value that is zero at a, as the sliding of what begins to slide, may
 * become positive before it is lost. */
static double watched_piece(struct search *search, int index, double a, double at_a, double b, double at_b)
{
    double from = a, at_twice = NAN;
    for (int i = 0; i < HALVINGS && at_a <= 0.0 && !falls_from_zero(at_a, at_twice); i++) {
        from = a + ldexp(b - a, -i - 1);
        at_twice = i ? at_a : at_b;
        at_a = one_watched(search, index, from);
    }
    return at_a > 0.0 ? root(search, one_watched, index, from, at_a, b, at_b) : a;
}

/* What watched value `index` is known to */
static double watched_noise(const struct search *search, int index)
{
    const struct system *s = search->s;
    const struct active_set *h = s->active;
    const struct mode_change loss = mode_change_of(s, index);
    double peak = 0.0;
    if (loss.how == SLIP_ENDS)
        return STILL * s->length / s->time;
    if (loss.how == BEARS) /* it has what it is known to in it */
        return 0.0;
    for (int i = 0; i < h->count; i++)
        peak = fmax(peak, h->peak[h->set[i]]);
    return FORCE_ROUNDING * peak * (loss.how == DETACHES ? 1.0 : 1.0 + s->friction[loss.contact]);
}

/* By how much the samples of a watched value in a window, every other one, miss the rest; `low`: the least of its samples, but
 * of a first one that is zero; `size`: the largest */
static double unforeseen(const double *samples, int count, double noise, double *low, double *size)
{
    double wrong = 0.0;
    *low = INFINITY;
    *size = 0.0;
    for (int i = 0; i <= SAMPLES; i++) {
        *low = i || fabs(samples[0]) > noise ? fmin(*low, samples[i * count]) : *low;
        *size = fmax(*size, fabs(samples[i * count]));
    }
    for (int i = 1; i < SAMPLES; i += 2) {
        double follows = 0.0;
        for (int j = 0; j <= SAMPLES; j += 2)
            follows += BETWEEN[i / 2][j / 2] / 128.0 * samples[j * count];
        wrong = fmax(wrong, fabs(samples[i * count] - follows));
    }
    return wrong;
}

/* 0 where the samples of all watched values in a window show what is between them: what every other one misses of the rest is
 * less than a part of the least, so that none comes to zero unseen. Else the largest miss, as a part of the value. */
static double unresolved(const struct search *search, const double *samples, int count)
{
    double found = 0.0;
    for (int w = 0; w < count; w++) {
        double low, size;
        const int how = mode_change_of(search->s, w).how;
        if (how == LOADS || how == BEARS) /* has kinks, and changes by rounding */
            continue;
        const double noise = watched_noise(search, w), wrong = unforeseen(samples + w, count, noise, &low, &size);
        if (wrong > noise && low < FORESEEN * wrong)
            found = fmax(found, wrong / size);
    }
    return found;
}

/* Whether the parabola through three samples at places 0, 1 and 2 has its least value between them; where, and which */
static int dips(const double *v, double *place, double *least)
{
    const double slope = 0.5 * (v[2] - v[0]), bend = v[2] - 2.0 * v[1] + v[0];
    *place = bend > 0.0 ? 1.0 - slope / bend : -1.0;
    *least = v[1] - 0.5 * slope * slope / bend;
    return *place > 0.0 && *place < 2.0;
}

/* Event of a watched value that is positive at three samples from theta a on, `width` apart, and less than zero between them, or
 * 2 where there is none: its least value is looked for by parabolas. */
static double dip(struct search *search, int index, double a, double width, const double *samples, double *behind)
{
    const double noise = watched_noise(search, index);
    double v[3] = {samples[0], samples[1], samples[2]}, from = a, place, least;
    for (int i = 0; i < DIPS && dips(v, &place, &least) && (i == 0 || least < -noise); i++) {
        if (least > SHALLOW * fmin(v[0], fmin(v[1], v[2])))
            return 2.0;
        const double theta = from + place * width, value = one_watched(search, index, theta);
        if (value < -noise) {
            *behind = theta;
            return root(search, one_watched, index, a, samples[0], theta, value);
        }
        width *= 0.25;
        from = fmin(fmax(theta - width, a), 1.0 - 2.0 * width);
        for (int j = 0; j < 3; j++)
            v[j] = one_watched(search, index, from + j * width);
    }
    return 2.0;
}

/* First event of watched value `index` among the samples of a window from theta a on, `width` apart, or 2 */
static double first_in_window(struct search *search, int index, int count, double a, double width,
                              const double *samples, double *behind)
{
    double v[SAMPLES + 1];
    for (int i = 0; i <= SAMPLES; i++)
        v[i] = samples[i * count + index];
    for (int i = 1; i <= SAMPLES; i++) {
        const int first = i == 1 ? 0 : i - 2; /* of three samples, the piece that ends at i among them */
        double place, least, theta = 2.0;
        *behind = a + i * width;
        if (v[i] < 0.0)
            return watched_piece(search, index, a + (i - 1) * width, v[i - 1], *behind, v[i]);
        const int before = v[first] > 0.0 && v[first + 1] > 0.0 && v[first + 2] > 0.0;
        if (before && dips(v + first, &place, &least))
            theta = dip(search, index, a + first * width, width, v + first, behind);
        if (theta <= 1.0)
            return theta;
    }
    return 2.0;
}

/* First event of the watched values of held contacts. They are looked at in windows that are halved until the samples in them
 * show what is between: a body at rest takes long steps whatever its loads do meanwhile. */
static struct event first_loss(struct search *search)
{
    struct event first = {-1, 2.0, CLOSES, 1.0};
    struct active_set *h = search->s->active;
    const int count = switching_count(search->s);
    double *samples = search->samples, behind;
    const double widest = (double)SAMPLES / (double)search->interval_count;
    const double least = SHORTEST_WINDOW * widest;
    double window = h->window > 0.0 ? fmin(widest, fmax(least, WINDOW_GROWTH * h->window / search->h)) : widest,
           before = INFINITY;
    int rounding = 0;
    search->watch(search, 0.0, samples);
    for (double a = 0.0; a < 1.0 && first.contact < 0;) {
        window = a + 1.01 * window >= 1.0 ? 1.0 - a : window;
        const double width = window / SAMPLES;
        for (int i = 1; i <= SAMPLES; i++)
            search->watch(search, i == SAMPLES && a + window >= 1.0 ? 1.0 : a + i * width, samples + i * count);
        const double wrong = rounding ? 0.0 : unresolved(search, samples, count);
        rounding |= wrong < JAGGED && wrong > 0.5 * before; /* it does not become less in a shorter window */
        if (wrong > 0.0 && !rounding && window > least) {
            before = wrong;
            window *= 0.5;
            continue;
        }
        before = INFINITY;
        for (int w = 0; w < count; w++) {
            if (!search->bears && mode_change_of(search->s, w).how == BEARS)
                continue;
            const double theta = first_in_window(search, w, count, a, width, samples, &behind);
            if (theta < first.theta)
                first = (struct event){mode_change_of(search->s, w).contact, theta, w, behind};
        }
        h->window = window * search->h;
        a += window;
        window = fmin(2.0 * window, widest);
        memcpy(samples, samples + SAMPLES * count, count * sizeof *samples);
    }
    return first;
}

/* Slope of watched value `index` over theta, from a difference over a millionth of a piece */
static double watched_slope(struct search *search, int index, double theta)
{
    const double step = SLOPE / (double)search->interval_count, from = fmin(theta, 1.0 - step);
    const double before = one_watched(search, index, from);
    return (one_watched(search, index, from + step) - before) / step;
}

/* First kink of effect `index` between two samples, or 2: its function is negative at the second, or falls at the first and rises at the second and is
 * negative where it is least. Functions of distances are sharp there: a point that flies past another has no parabola. */
static double kink_in_piece(struct search *search, int index, const struct sampled *a, const struct sampled *b,
                            double *behind)
{
    const double at_a = a->value[index], at_b = b->value[index], falls = a->rate[index], rises = b->rate[index];
    *behind = b->theta;
    if (at_b < -search->noise[index])
        return watched_piece(search, index, a->theta, at_a, b->theta, at_b);
    if (at_a <= 0.0 || falls >= 0.0 || rises <= 0.0)
        return 2.0;
    const double bottom = root(search, watched_slope, index, a->theta, falls, b->theta, rises);
    const double least = one_watched(search, index, bottom);
    *behind = bottom;
    return least < -search->noise[index] ? root(search, one_watched, index, a->theta, at_a, bottom, least) : 2.0;
}

/* First kink of an effect between two samples: functions of the state alone, that a step resolves as it does the state. */
static struct event first_kink(struct search *search, const struct sampled *a, const struct sampled *b)
{
    struct event first = {-1, 2.0, -1, 1.0};
    double behind;
    for (int w = 0; w < search->sampled_count; w++) {
        const double theta = kink_in_piece(search, w, a, b, &behind);
        if (theta < first.theta)
            first = (struct event){-1, theta, w, behind};
    }
    return first;
}

static void take_sampled(struct arena *arena, size_t count, struct sampled *sampled)
{
    sampled->value = TAKE(arena, double, count);
    sampled->rate = TAKE(arena, double, count);
}

static enum outcome take_search(struct search *search, size_t watched)
{
    struct system *s = search->s;
    const size_t count = (size_t)search->sampled_count;
    search->y = TAKE(s->arena, double, s->size);
    search->dy = TAKE(s->arena, double, s->size);
    search->values = TAKE(s->arena, double, watched);
    search->velocities = TAKE(s->arena, double, 3 * (size_t)s->model->links);
    for (int i = 0; i < 3; i++)
        take_sampled(s->arena, count, &search->ends[i]);
    for (int i = 0; i < CLOSER; i++)
        take_sampled(s->arena, count, &search->between[i]);
    search->samples = TAKE(s->arena, double, (SAMPLES + 1) * watched);
    if (s->arena->ran_out)
        return OUTCOME_NO_MEMORY;
    search->interval_count = interval_count(search);
    return OUTCOME_DONE;
}

enum outcome find_event(struct system *s, const struct method *method, const double *steps, double t, double h,
                        double slow, int bears, struct event *event)
{
    struct search search = {.s = s,
                            .method = method,
                            .steps = steps,
                            .t = t,
                            .h = h,
                            .slow = slow,
                            .bears = bears,
                            .watch = watch_contacts,
                            .take_sample = sample_gaps,
                            .first_in_piece = first_closing,
                            .sampled_count = s->model->contacts,
                            .span = h};
    const struct mark mark = s->arena->top;
    const enum outcome outcome = take_search(&search, WATCHED_MOST * (size_t)s->model->contacts);
    if (!outcome) {
        *event = first_sampled(&search);
        const struct event loss = active_count(s) ? first_loss(&search) : *event;
        *event = loss.theta < event->theta ? loss : *event;
    }
    give_back(s->arena, mark);
    return outcome;
}

enum outcome find_kink(struct system *s, const struct method *method, const double *steps, double t, double h,
                       struct event *event)
{
    struct search search = {.s = s,
                            .method = method,
                            .steps = steps,
                            .t = t,
                            .h = h,
                            .watch = watch_effects,
                            .take_sample = sample_effects,
                            .first_in_piece = first_kink,
                            .sampled_count = s->model->switches,
                            .span = 1.0};
    const struct mark mark = s->arena->top;
    search.noise = TAKE(s->arena, double, s->model->switches);
    enum outcome outcome = take_search(&search, s->model->switches);
    if (!outcome) {
        method->interpolate(steps, s->size, 0.0, search.y);
        outcome = side_noise(s, t, search.y, search.dy, search.values, search.samples, search.noise);
    }
    if (!outcome)
        *event = first_sampled(&search);
    give_back(s->arena, mark);
    return outcome;
}
