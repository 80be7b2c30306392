/* What a search through a step looks at; see step_search.h. */
#include "steps/step_search.h"

#include <limits.h>
#include <math.h>

#include "base/tolerances.h"
#include "motion/sides.h"
#include "motion/switching.h"

enum { ITERATIONS = 100 /* in search of a root: bisection alone needs 50 */ };

long interval_count(struct search *search)
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

void watch_contacts(struct search *search, double theta, double *values)
{
    struct system *s = search->s;
    search->method->interpolate(search->steps, s->size, theta, search->y);
    if (switching_functions(s, search->t + theta * search->h, search->y, search->dy, values))
        for (int i = 0; i < switching_count(s); i++)
            values[i] = -1.0;
}

void watch_effects(struct search *search, double theta, double *values)
{
    struct system *s = search->s;
    search->method->interpolate(search->steps, s->size, theta, search->y);
    if (side_functions(s, search->t + theta * search->h, search->y, s->sides, values))
        for (int i = 0; i < s->model->switches; i++)
            values[i] = -1.0;
}

double one_watched(struct search *search, int index, double theta)
{
    search->watch(search, theta, search->values);
    return search->values[index];
}

double root_between(struct search *search, double (*f)(struct search *, int, double), int index, double a, double fa,
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
        const double fc = f(search, index, c);
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

int falls_from_zero(double value, double at_twice)
{
    return value < 0.0 && value <= FALLING * at_twice;
}

double first_negative(struct search *search, int index, double a, double at_a, double b, double at_b)
{
    double from = a, at_twice = NAN;
    for (int i = 0; i < HALVINGS && at_a <= 0.0 && !falls_from_zero(at_a, at_twice); i++) {
        from = a + ldexp(b - a, -i - 1);
        at_twice = i ? at_a : at_b;
        at_a = one_watched(search, index, from);
    }
    return at_a > 0.0 ? root_between(search, one_watched, index, from, at_a, b, at_b) : a;
}
