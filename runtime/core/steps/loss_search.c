/* Search for the loss of held contacts, in windows; see loss_search.h. */
#include "steps/loss_search.h"

#include <math.h>
#include <string.h>

#include "base/tolerances.h"
#include "constraints/branch.h"
#include "motion/switching.h"

enum { DIPS = 12 /* parabolas in search of a least value */ };

static const double WINDOW_GROWTH =
    6.0; /* how much longer than the last a first window may be: as much as steps grow */
/* 128 times what the samples 1, 3, 5 and 7 are if a polynomial of degree 4 goes through 0, 2, 4, 6 and 8 */
static const double BETWEEN[4][5] = {
    {35, 140, -70, 28, -5}, {-5, 60, 90, -20, 3}, {3, -20, 90, 60, -5}, {-5, 28, -70, 140, 35}};

/* What watched value `index` is known to: of forces along a branch rounding / sigma */
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
    return fmax(FORCE_ROUNDING / nearest_margin(s) * peak, missed_force(s, search->y)) *
           (loss.how == DETACHES ? 1.0 : 1.0 + s->friction[loss.contact]);
}

/* By how much the samples of a watched value in a window, every other one, miss the rest, 0 where one is infinite: nothing shows when what others keep is lost; `low`: the least of its samples, but
 * of a first one that is zero; `size`: the largest */
static double unforeseen(const double *samples, int count, double noise, double *low, double *size)
{
    double wrong = 0.0;
    *low = INFINITY;
    *size = 0.0;
    for (int i = 0; i <= SAMPLES; i++)
        if (samples[i * count] == INFINITY)
            return 0.0;
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
            return root_between(search, one_watched, index, a, samples[0], theta, value);
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
            return first_negative(search, index, a + (i - 1) * width, v[i - 1], *behind, v[i]);
        const int before = v[first] > 0.0 && v[first + 1] > 0.0 && v[first + 2] > 0.0;
        if (before && dips(v + first, &place, &least))
            theta = dip(search, index, a + first * width, width, v + first, behind);
        if (theta <= 1.0)
            return theta;
    }
    return 2.0;
}

struct event first_loss(struct search *search)
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
