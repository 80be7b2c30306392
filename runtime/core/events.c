/* One-sided event search on the dense output of a step.
 *
 * The step is looked at through SAMPLES pieces, or more where links turn far in it, as in a steady rotation. Within a piece
 * the gap of a contact and its rate at both ends tell what can happen: it crosses zero, or falls and rises again with its
 * least value inside, or is closed at first, opens, and closes. Extrema are roots of the rate, so a dip is found however
 * short it is against the piece.
 */
#include "events.h"

#include <limits.h>
#include <math.h>

#include "contact.h"

static const double SHUT = 1e-12; /* times extent: a gap so small, where nothing moves, is closed */
static const double TURN = 0.25;  /* rad by which links turn against each other in a piece */
enum { SAMPLES = 8, ITERATIONS = 100, HALVINGS = 40 };

struct search {
    struct system *s;
    const struct method *method;
    const double *steps;
    double t, h;
    double *y, *dy, *value;
    double slow; /* times extent: a closed contact is not falling before its rate is beyond this */
    long pieces;
};

/* all gaps (or their rates) at theta */
static void look(struct search *search, double theta, double *gaps, double *rates)
{
    const struct ccgen_model *m = search->s->model;
    search->method->interpolate(search->steps, search->s->size, theta, search->y);
    if (gaps)
        m->gaps(search->s->k, search->y, gaps);
    if (rates)
        m->gap_rates(search->s->k, search->y, search->y + search->s->n, rates);
}

static double gap(struct search *search, int contact, double theta)
{
    look(search, theta, search->value, NULL);
    return search->value[contact];
}

static double rate(struct search *search, int contact, double theta)
{
    look(search, theta, NULL, search->value);
    return search->value[contact];
}

/* Pieces in which to look at the step: gaps come and go with every turn of a link, however long the step */
static long pieces(struct search *search, double *velocities)
{
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
    return wanted > SAMPLES && wanted < LONG_MAX / 2 ? (long)wanted + 1 : SAMPLES;
}

/* the watched values at theta; what cannot be computed counts as lost */
static void watch_at(struct search *search, double theta, double *values)
{
    struct system *s = search->s;
    search->method->interpolate(search->steps, s->size, theta, search->y);
    if (watch(s, search->t + theta * search->h, search->y, search->dy, values))
        for (int i = 0; i < watched(s); i++)
            values[i] = -1.0;
}

static double one_watched(struct search *search, int index, double theta)
{
    watch_at(search, theta, search->value);
    return search->value[index];
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
static double piece(struct search *search, int contact, double a, double ga, double ra, double b, double gb, double rb)
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
    if (gb <= 0.0 && ra > 0.0 && rb < 0.0) { /* it rises first: past the top there is one entry, and no rounding near a */
        const double top = root(search, rate, contact, a, ra, b, rb);
        const double highest = gap(search, contact, top);
        return highest > 0.0 ? root(search, gap, contact, top, highest, b, gb < 0.0 ? gb : -1e-300) : top;
    }
    if (gb <= 0.0)
        return root(search, gap, contact, a, ga, b, gb < 0.0 ? gb : -1e-300);
    if (ra < 0.0 && rb > 0.0) {
        const double bottom = root(search, rate, contact, a, ra, b, rb);
        const double lowest = gap(search, contact, bottom);
        if (lowest <= 0.0)
            return root(search, gap, contact, a, ga, bottom, lowest < 0.0 ? lowest : -1e-300);
    }
    return 2.0;
}

/* First event of the gaps of contacts that are not held */
static struct event first_closing(struct search *search)
{
    const struct system *s = search->s;
    const int contacts = s->model->contacts;
    struct event first = {-1, 2.0, CLOSES};
    double *gap_a = search->value + 2 * contacts, *rate_a = gap_a + contacts;
    double *gap_b = rate_a + contacts, *rate_b = gap_b + contacts;
    look(search, 0.0, gap_a, rate_a);
    for (long i = 0; i < search->pieces && first.contact < 0 && !interrupted(search->s, contacts); i++) {
        const double a = (double)i / search->pieces, b = (i + 1.0) / search->pieces;
        look(search, b, gap_b, rate_b);
        for (int c = 0; c < contacts; c++) {
            if (s->holding && s->holding->closed[c])
                continue;
            const double theta = piece(search, c, a, gap_a[c], rate_a[c], b, gap_b[c], rate_b[c]);
            if (theta < first.theta)
                first = (struct event){c, theta, CLOSES};
        }
        double *swap = gap_a;
        gap_a = gap_b;
        gap_b = swap;
        swap = rate_a;
        rate_a = rate_b;
        rate_b = swap;
    }
    return first;
}

/* Event of a watched value that is lost at theta b. A value that is zero at a, as the sliding of what begins to slide, may
 * become positive before it is lost. */
static double watched_piece(struct search *search, int index, double a, double at_a, double b, double at_b)
{
    double from = a;
    for (int i = 0; i < HALVINGS && at_a <= 0.0; i++) {
        from = a + ldexp(b - a, -i - 1);
        at_a = one_watched(search, index, from);
    }
    return at_a > 0.0 ? root(search, one_watched, index, from, at_a, b, at_b) : a;
}

/* First event of the watched values of held contacts */
static struct event first_loss(struct search *search)
{
    struct event first = {-1, 2.0, CLOSES};
    const int count = watched(search->s);
    double *before = search->value + 3 * search->s->model->contacts, *after = before + count;
    watch_at(search, 0.0, before);
    for (long i = 0; i < search->pieces && first.contact < 0; i++) {
        const double a = (double)i / search->pieces, b = (i + 1.0) / search->pieces;
        watch_at(search, b, after);
        for (int w = 0; w < count; w++) {
            if (after[w] >= 0.0)
                continue;
            const double theta = watched_piece(search, w, a, before[w], b, after[w]);
            if (theta < first.theta)
                first = (struct event){watcher(search->s, w).contact, theta, w};
        }
        double *swap = before;
        before = after;
        after = swap;
    }
    return first;
}

size_t search_scratch(const struct system *s)
{
    return 2 * (size_t)s->size + 9 * (size_t)s->model->contacts + 3 * (size_t)s->model->links;
}

struct event find_event(struct system *s, const struct method *method, const double *steps, double t, double h, double slow,
                        double *scratch)
{
    double *value = scratch + 2 * s->size;
    struct search search = {s, method, steps, t, h, scratch, scratch + s->size, value, slow, SAMPLES};
    search.pieces = pieces(&search, value + 9 * s->model->contacts);
    const struct event closing = first_closing(&search);
    if (!holds(s))
        return closing;
    const struct event loss = first_loss(&search);
    return loss.theta < closing.theta ? loss : closing;
}
