/* States beside a singular configuration, cut off a step past it.
 *
 * A step that ends there has to be put back where rows are nearly dependent, which makes velocities wrong by 1 / sigma times what they miss, and an
 * error estimate of it measures that: no step is short enough. Of a step that passes the configuration between two of its stages all stages are
 * known; their polynomial tells the states between them. With s stages a step of order 2 s misses (h / T)^(2 s), its polynomial (h / T)^(s + 1),
 * T being how far the motion is analytic (E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, 1993, section
 * II.7). Where h is the length that the tolerance allows a step, the polynomial of one an eighth as long misses rtol^((s + 1) / (2 s)) / 8^(s + 1): with
 * the eight stages here less than rtol down to 1e-18.
 */
#include "steps/cut_step.h"

#include <float.h>
#include <math.h>

#include "base/tolerances.h"
#include "constraints/nullspace.h"
#include "methods/gauss.h"
#include "steps/singular_step.h"

/* A step that is cut begins before the place by an eighth (LENGTH) to half (LONGEST) of what one that missed too much did. Its end may lie beside the
 * place, which is in its MIDDLE, by REACH of its length; and by REACH of an eighth of the length that the tolerance allows a step */
static const double LENGTH = 0.125, REACH = 0.4, MIDDLE = 0.5;
static const double SAFETY = 0.9,
                    LONGEST = 0.5;    /* of a step that is cut after one that missed too much, by the length of that */
static const double NEARER = 5.45;    /* 0.5 / 0.0917: from the middle to the beginning, and to the next stage */
static const double FIRST_GAP = 0.06; /* the middle between the first two stages, from the beginning */
enum {
    AGAIN = 4, /* times that the configuration is looked for again */
    TRIES =
        2 /* cut steps that missed too much, each but the first as short as the last one asked for: what the next one misses is not known there */
};

double near_dependence(const struct phase *f)
{
    return sqrt(ACROSS_KNOWN * DBL_EPSILON / fmax(f->run->tolerance.rtol, KNOWN_AT_LEAST));
}

/* What the polynomial of a step with the place in its middle may miss: the tolerance, or what is unknown at its two stages nearest to the place. Shorter steps
 * have these nearer still. */
static struct tolerance tolerance_of_cut(const struct phase *f, int near)
{
    struct tolerance tolerance = f->run->tolerance;
    const double worst = NEARER * NEARER * unknown_velocity(f), unknown = near ? worst : fmin(worst, KNOWN_AT_LEAST);
    tolerance.atol = fmax(tolerance.atol, unknown * fastest(f->s, f->y + f->s->n) * f->s->time);
    return tolerance;
}

/* The state y1 after f->h, beside f->place, cut off a step that goes on past both and is about `length` long, but not past the time `limit`; in *error what its
 * polynomial misses, in tolerances: infinity where there is none. `near` is whether it begins where less is known than the tolerance. */
static enum outcome cut_step(struct phase *f, double length, double limit, int near, double *error)
{
    struct system *s = f->s;
    const double way = f->h;
    enum outcome outcome = OUTCOME_DONE;
    int misses = 1;
    *error = INFINITY;
    for (int i = 0; !outcome && misses; i++) {
        const double place = f->at.place - f->t, clear = between_stages(place / length);
        f->h = clear > 0.0 ? place / clear : length;
        if (i > AGAIN || f->h < way || f->t + f->h > limit) {
            outcome = OUTCOME_NO_CONVERGENCE;
            break;
        }
        f->at.passage = ACROSS;
        outcome = unprojected_step(f, f->h, f->run->tolerance);
        misses = !outcome && misplaced(f, f->y1);
    }
    if (!outcome)
        *error = gauss_cut(s, f->steps, way / f->h, tolerance_of_cut(f, near), f->y, f->y1);
    f->h = way;
    return outcome || isfinite(*error) ? outcome : OUTCOME_NO_CONVERGENCE;
}

int can_be_cut(const struct phase *f, double way)
{
    const double until = f->at.place - f->t;
    return fabs(until - way) <= REACH * until / MIDDLE;
}

int ends_beside_singularity(const struct phase *f, double allowed)
{
    const double until = f->at.place - f->t, beside = fabs(until - f->h);
    return f->at.bounded && beside <= REACH * fmin(until / MIDDLE, LENGTH * fmax(f->h, allowed)) && projects(f) &&
           !active_count(f->s) && f->run->fixed_step == 0.0 && (f->run->method == &gauss || f->passing) &&
           !f->s->model->switches && !f->s->input_source;
}

enum outcome cut_or_shorten(struct phase *f, int tries, double limit, int *ends)
{
    const double whole = f->h, until = f->at.place - f->t, beside = fabs(until - whole);
    const double nearest = near_dependence(f) / rank_margin(f->s, f->y);   /* of the way to the place */
    const double least = fmax(nearest, MIDDLE * beside / (REACH * until)); /* of a step that is cut, to its middle */
    const double most = (limit - f->at.place) / until;
    const int near = nearest > LONGEST; /* so that its stages are the better the farther they lie from the place */
    double error = INFINITY;
    enum outcome outcome = OUTCOME_DONE;
    *ends = 0;
    if (!(fmin(least, 1.0) <= most))
        return OUTCOME_DONE;
    if (near)
        outcome = cut_step(f, until / FIRST_GAP, limit, near, &error);
    if (most >= 1.0 && outcome != OUTCOME_INTERRUPTED && !(error <= 1.0))
        outcome = cut_step(f, until / MIDDLE, limit, near, &error);
    *ends = !outcome && (error <= 1.0 || (tries >= TRIES && !near && isfinite(error)));
    if (*ends || outcome == OUTCOME_INTERRUPTED || outcome == OUTCOME_NO_MEMORY)
        return outcome;
    const double wanted = fmin(fmax(SAFETY * pow(error, -1.0 / (STAGES + 1)), LENGTH), fmin(LONGEST, most));
    const double part = fmax(wanted, least);
    if (part < 1.0 && part <= most && (1.0 - part) * until < whole) {
        f->h = (1.0 - part) * until;
        f->at.passage = BEFORE;
    }
    return OUTCOME_DONE;
}

enum outcome end_beside_singularity(struct phase *f, int *ends)
{
    const double whole = f->h;
    const enum outcome outcome = cut_or_shorten(f, f->at.cuts, next_kink(f->run, f->t), ends);
    f->at.cuts = *ends ? 0 : f->at.cuts + (f->h < whole);
    return outcome;
}
