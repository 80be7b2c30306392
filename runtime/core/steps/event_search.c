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
#include <math.h>

#include "base/tolerances.h"
#include "constraints/active_set.h"
#include "motion/sides.h"
#include "model/contacts.h"
#include "steps/loss_search.h"
#include "steps/step_search.h"

enum { WATCHED_MOST = 3 /* values of a held contact: its force, and two of its friction where it sticks */ };

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
        const double top = root_between(search, rate, contact, a, ra, b, rb);
        const double highest = gap(search, contact, top);
        return highest > 0.0 ? root_between(search, gap, contact, top, highest, b, gb) : top;
    }
    if (gb <= 0.0 && ra > 0.0 &&
        rb < 0.0) { /* it rises first: past the top there is one entry, and no rounding near a */
        const double top = root_between(search, rate, contact, a, ra, b, rb);
        const double highest = gap(search, contact, top);
        return highest > 0.0 ? root_between(search, gap, contact, top, highest, b, gb < 0.0 ? gb : -DBL_MIN) : top;
    }
    if (gb <= 0.0)
        return root_between(search, gap, contact, a, ga, b, gb < 0.0 ? gb : -DBL_MIN);
    if (ra < 0.0 && rb > 0.0) {
        const double bottom = root_between(search, rate, contact, a, ra, b, rb);
        const double lowest = gap(search, contact, bottom);
        if (lowest <= 0.0)
            return root_between(search, gap, contact, a, ga, bottom, lowest < 0.0 ? lowest : -DBL_MIN);
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
        return first_negative(search, index, a->theta, at_a, b->theta, at_b);
    if (at_a <= 0.0 || falls >= 0.0 || rises <= 0.0)
        return 2.0;
    const double bottom = root_between(search, watched_slope, index, a->theta, falls, b->theta, rises);
    const double least = one_watched(search, index, bottom);
    *behind = bottom;
    return least < -search->noise[index] ? root_between(search, one_watched, index, a->theta, at_a, bottom, least)
                                         : 2.0;
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

/* Whether no kink of an effect is near in the step: each function stays farther above zero at all samples than what it changes by between any two of them, twice. So a dip between
 * two, as of a distance where a point flies past another, would have to be as deep as two of the largest changes that show. Samples lie where those of the search do, so that no period
 * comes to all of them in the same phase. */
static int is_far_from_kinks(struct search *search)
{
    const int count = search->sampled_count;
    double *least = search->ends[0].value, *most = search->ends[0].rate, *before = search->ends[1].value,
           *now = search->ends[2].value;
    for (long k = 0; k <= search->interval_count; k++) {
        const double whole = (double)search->interval_count, at = (double)k / whole;
        watch_effects(search, k % 2 ? parted(at - 1.0 / whole, at + 1.0 / whole) : at, now);
        for (int i = 0; i < count; i++) {
            const double change = k ? fabs(now[i] - before[i]) : 0.0;
            least[i] = k ? fmin(least[i], now[i]) : now[i];
            most[i] = k ? fmax(most[i], change) : 0.0;
            before[i] = now[i];
            if (!(now[i] > 0.0))
                return 0;
        }
    }
    for (int i = 0; i < count; i++)
        if (!(least[i] > 2.0 * most[i]))
            return 0;
    return 1;
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
    const int far = !outcome && is_far_from_kinks(&search);
    if (far)
        *event = (struct event){-1, 2.0, CLOSES, 1.0};
    if (!outcome && !far) {
        method->interpolate(steps, s->size, 0.0, search.y);
        outcome = side_noise(s, t, search.y, search.dy, search.values, search.samples, search.noise);
    }
    if (!outcome && !far)
        *event = first_sampled(&search);
    give_back(s->arena, mark);
    return outcome;
}
