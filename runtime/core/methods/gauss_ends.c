/* Gauss-Legendre collocation: what a step has not seen.
 *
 * No stage lies at either end of a step, and the first fiftieth of it lies before all of them. What happens within that and is over, as friction
 * that sets in where a motion starts from rest, leaves the stage polynomial as smooth as if it were not there. So the accelerations at both ends are
 * compared with what the polynomial has there.
 *
 * The polynomial of an analytic motion misses them too, and the end of the step does not see that: it is orthogonal to all that the quadrature
 * weighs. What it misses then goes on from its last coefficients as these do from those before: with coefficients that shrink by a factor each, the
 * two last together by `shrink` against the two before, the missing ones sum up to about sqrt(shrink) times the last. Twice that is `explained`,
 * and what rounding leaves of the accelerations, carried on to the end. The rest lasts up to the next stage at most, and changes the velocities by
 * no more than that times the way there.
 *
 * Where a run begins anew that is done for every model, further on where something may set in.
 */
#include "constraints/branch.h"
#include "methods/gauss.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "motion/derivative.h"

static const double EXPLAINED = 2.0;
static const double CARRIED = 5.6; /* 1 + sum over the stages of what the polynomial at an end takes of each, in size */
static const double UNIT = 4.0 * DBL_EPSILON;

/* What is left of a miss beside this noise */
static double beyond(double miss, double noise)
{
    return fabs(miss) > noise ? miss - copysign(noise, miss) : 0.0;
}

/* missed[size] = changes of the state by what the accelerations and the power dy at this end (0 or 1) of the step differ by from the stage polynomial, as if
 * that lasted for all of the step */
static void compare(const struct gauss *g, const struct system *s, int end, const double *dy, double *missed)
{
    const int n = g->n;
    const double h = g->h;
    for (int i = 0; i < g->rows; i++) {
        const double *c = g->legendre + i * STAGES;
        const double even = (c[0] + c[2]) + (c[4] + c[6]), odd = (c[1] + c[3]) + (c[5] + c[7]);
        const double noise = i < n ? g->noise * s->unit[i] : UNIT * fabs(h) * (fabs(even) + fabs(odd));
        const double miss = dy[n + i] - (end ? even + odd : even - odd);
        missed[n + i] = beyond(h * miss, CARRIED * noise);
        if (i < n)
            missed[i] = end ? 0.0 : h * missed[n + i];
    }
}

/* The last time within a step up to `to`, which t + h may pass by rounding: what sets in at its end is the next step's */
static double just_before(double to, double h)
{
    return to - copysign(DBL_EPSILON * fabs(to), h);
}

enum outcome gauss_look_at_ends(struct gauss *g, struct system *s, double t, double h, const double *y,
                                const double *y1)
{
    double *missed = g->estimate + 2 * s->size;
    const double t1 = just_before(t + h, h);
    memset(missed, 0, 2 * s->size * sizeof *missed);
    g->ended = 0;
    if (!passes_by(s) && (s->branch || !(g->fresh || gauss_has_loads(s))))
        return OUTCOME_DONE;
    enum outcome outcome = g->begun ? OUTCOME_DONE : system_derivative(s, t, y, g->begin);
    g->begun = !outcome;
    if (!outcome) {
        compare(g, s, 0, g->begin, missed);
        outcome = system_derivative(s, t1, y1, g->end);
        g->ended = !outcome;
    }
    if (!outcome)
        compare(g, s, 1, g->end, missed + s->size);
    return outcome == OUTCOME_INTERRUPTED ? outcome : OUTCOME_DONE;
}

double gauss_unseen(const struct gauss *g, int size, struct tolerance tolerance, const double *y, const double *y1)
{
    const int n = g->n;
    const double *begin = g->estimate + 2 * size, *end = begin + size, h = g->h;
    double last = 0.0, before = 0.0, at_begin = 0.0, at_end = 0.0;
    for (int i = 0; i < g->rows; i++) {
        const double *c = g->legendre + i * STAGES;
        const double scale = 1.0 / allowed_error(tolerance, n + i, fmax(fabs(y[n + i]), fabs(y1[n + i])));
        const double of_u = h * scale;
        double weight = of_u * of_u;
        at_begin += begin[n + i] * begin[n + i] * scale * scale;
        at_end += end[n + i] * end[n + i] * scale * scale;
        if (i < n) {
            const double of_q = 1.0 / allowed_error(tolerance, i, fmax(fabs(y[i]), fabs(y1[i])));
            weight += h * h * h * h * of_q * of_q;
            at_begin += begin[i] * begin[i] * of_q * of_q;
        }
        last += weight * (c[7] * c[7] + c[6] * c[6]);
        before += weight * (c[5] * c[5] + c[4] * c[4]);
    }
    const double shrink = before > last ? sqrt(last / before) : 1.0;
    const double explained = EXPLAINED * sqrt(last * shrink), missed = sqrt(fmax(at_begin, at_end));
    const double unseen = NODE[0] * fmax(0.0, missed - explained) / sqrt(size);
    return fmin(
        unseen,
        pow(DBL_MAX, 0.9 / ORDER)); /* its power is an error, and finite, for projection to take what it can from it */
}
