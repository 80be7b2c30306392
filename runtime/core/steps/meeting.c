/* Steps come near where the ends of a line meet, and only a short one passes; see meeting.h. */
#include "steps/meeting.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "base/tolerances.h"

static const double SHARP =
    2.0; /* pieces that are this many times as long as a line is see too little of how it turns */
static const double NEARER = 0.9; /* of the time to where the ends meet: a digit of it is known even across a jump */
enum { PIECES = 8, ROUNDINGS = 64 };

/* Where a line has been shortest so far */
struct nearest {
    double square, theta; /* its squared length (m^2), and in which part of the step */
    double way;           /* the squared length (m^2) of the piece of its second end's way */
};

/* Take the piece of a way from a[2] to b[2], between parts theta and theta + 1 / PIECES of the step, as straight. */
static void pass_piece(const double *a, const double *b, double theta, struct nearest *nearest)
{
    const double x = b[0] - a[0], y = b[1] - a[1], way = x * x + y * y;
    const double part = way > 0.0 ? fmin(1.0, fmax(0.0, -(a[0] * x + a[1] * y) / way)) : 0.0;
    const double to_x = a[0] + part * x, to_y = a[1] + part * y, square = to_x * to_x + to_y * to_y;
    if (square < nearest->square)
        *nearest = (struct nearest){square, theta + part / PIECES, way};
}

/* The distance (m) of two places */
static double distance(const double *a, const double *b)
{
    const double x = b[0] - a[0], y = b[1] - a[1];
    return sqrt(x * x + y * y);
}

/* Whether the ends of a line are not where they meet already, to rounding of places: nothing is left to come near to. What a spring's force
 * jumps by from there on is work over no more than that way, so that a step of any length may pass. Ends that come to rest there, as those
 * of a strut, would else be met again by every step. */
static int are_apart(const struct system *s, const double *reach)
{
    const double met[2] = {0.0, 0.0};
    return !(distance(met, reach) <= SHUT * s->length);
}

/* Whether a line may come near to where its ends meet: at both ends of the step or in its middle, by the cubic of its ends, it is shorter than
 * the way that its second end goes. Most steps are done with that. */
static enum outcome comes_near(struct phase *f, int *near)
{
    struct system *s = f->s;
    const struct ccgen_model *m = s->model;
    const struct mark mark = s->arena->top;
    const double met[2] = {0.0, 0.0};
    const size_t n = s->n, numbers = 2 * (size_t)m->lines;
    double *q = TAKE(s->arena, double, n), *at = TAKE(s->arena, double, 3 * numbers);
    *near = 0;
    if (s->arena->ran_out)
        return OUTCOME_NO_MEMORY;
    for (size_t i = 0; i < n; i++)
        q[i] = 0.5 * (f->y[i] + f->y1[i]) + 0.125 * f->h * (f->y[n + i] - f->y1[n + i]);
    m->reaches(s->k, f->y, at);
    m->reaches(s->k, q, at + numbers);
    m->reaches(s->k, f->y1, at + 2 * numbers);
    for (size_t i = 0; i < numbers; i += 2) {
        const double *a = at + i, *b = a + numbers, *c = b + numbers;
        const double shortest = fmin(distance(met, a), fmin(distance(met, b), distance(met, c)));
        *near |= are_apart(s, a) && !(shortest > distance(a, b) + distance(b, c));
    }
    give_back(s->arena, mark);
    return OUTCOME_DONE;
}

/* The first part of the step at which the ends of a line all but meet, or 1, by the dense output */
static enum outcome first_meeting(struct phase *f, double *theta)
{
    struct system *s = f->s;
    const struct ccgen_model *m = s->model;
    const struct mark mark = s->arena->top;
    const size_t lines = m->lines;
    double *y = TAKE(s->arena, double, s->size), *a = TAKE(s->arena, double, 2 * lines);
    double *b = TAKE(s->arena, double, 2 * lines);
    struct nearest *nearest = TAKE(s->arena, struct nearest, lines);
    const enum outcome outcome = s->arena->ran_out ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    if (!outcome)
        m->reaches(s->k, f->y, a);
    for (size_t i = 0; i < lines && !outcome; i++)
        nearest[i] = (struct nearest){are_apart(s, a + 2 * i) ? INFINITY : 0.0, 0.0, 0.0};
    for (int piece = 0; piece < PIECES && !outcome; piece++) {
        f->by->interpolate(f->steps, s->size, (piece + 1.0) / PIECES, y);
        m->reaches(s->k, y, b);
        for (size_t i = 0; i < lines; i++)
            pass_piece(a + 2 * i, b + 2 * i, (double)piece / PIECES, &nearest[i]);
        memcpy(a, b, 2 * lines * sizeof *a);
    }
    *theta = 1.0;
    for (size_t i = 0; i < lines && !outcome; i++)
        if (nearest[i].theta > 0.0 && nearest[i].square < SHARP * SHARP * nearest[i].way)
            *theta = fmin(*theta, nearest[i].theta);
    give_back(s->arena, mark);
    return outcome;
}

enum outcome refuse_before_meeting(struct phase *f, int *refused)
{
    const double rounding = ROUNDINGS * DBL_EPSILON * fabs(f->t);
    const double least = fmax(MEETING * f->s->time, rounding);
    double theta = 1.0;
    int near;
    *refused = 0;
    f->at.meets = 0.0;
    if (!f->s->model->lines || f->h <= least)
        return OUTCOME_DONE;
    enum outcome outcome = comes_near(f, &near);
    if (outcome || !near)
        return outcome;
    outcome = evaluate_end_derivative(f);
    outcome = outcome ? outcome : f->by->prepare(f->s, f->steps, f->t, f->h, f->y, f->dy, f->y1, f->dy1);
    outcome = outcome ? outcome : first_meeting(f, &theta);
    *refused = !outcome && theta < 1.0;
    if (*refused) {
        f->at.meets = fmax(NEARER * theta * f->h, least);
        f->run->steps--;
        f->run->rejected++;
    }
    return outcome;
}
