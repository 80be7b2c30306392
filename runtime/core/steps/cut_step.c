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
#include <string.h>

#include "base/tolerances.h"
#include "constraints/nullspace.h"
#include "methods/gauss.h"
#include "motion/derivative.h"
#include "motion/projection.h"
#include "steps/singular_step.h"
#include "steps/step_control.h"

const double CUT_LENGTH = 0.125, CUT_REACH = 0.4;
static const double MIDDLE = 0.5;
enum { AGAIN = 4 }; /* times that the configuration is looked for again */

enum outcome cut_step(struct phase *f, double until, double length, double *error)
{
    struct system *s = f->s;
    const double way = until - f->t;
    enum outcome outcome = OUTCOME_DONE;
    for (int i = 0; !outcome; i++) {
        const double place = f->at.place - f->t, clear = between_stages(place / length);
        f->h = clear > 0.0 ? place / clear : length;
        if (f->h < way) /* it begins beside the place */
            f->h = fmax(length, way);
        f->at.passage = ACROSS;
        outcome = unprojected_step(f, f->h, f->run->tolerance);
        if (outcome || i == AGAIN || !misplaced(f, f->y1))
            break;
    }
    *error = 0.0;
    outcome = outcome || f->run->tolerance.rtol == 0.0 ? outcome : step_error(f, error);
    if (!outcome && !gauss_cut(s, f->steps, way / f->h, f->y, f->y1))
        outcome = OUTCOME_NO_CONVERGENCE;
    f->h = way;
    return outcome ? outcome : project_position(s, f->y1);
}

/* How near to dependence rows are where velocities are just known to the tolerance, or if that is finer to the default one */
static double near_dependence(const struct phase *f)
{
    return sqrt(ACROSS_KNOWN * DBL_EPSILON / fmax(f->run->tolerance.rtol, KNOWN_AT_LEAST));
}

/* How near to dependence rows are at time t on the cubic to end[2n] */
static double margin_at(struct phase *f, const double *end, double t)
{
    const struct mark mark = f->s->arena->top;
    double *q = TAKE(f->s->arena, double, f->s->n);
    double margin = INFINITY;
    if (!f->s->arena->ran_out) {
        between_ends(f, f->h, end, (t - f->t) / f->h, q);
        margin = rank_margin(f->s, q);
    }
    give_back(f->s->arena, mark);
    return margin;
}

int lies_beside_singularity(struct phase *f, const double *end, double t)
{
    double part;
    if (!f->s->model->rows || !projects(f) || active_count(f->s) || (f->run->method != &gauss && !f->passing) ||
        !(margin_at(f, end, t) < near_dependence(f)) || !nearest_part(f, end, 1.0, &part))
        return 0;
    f->at.place = f->t + part * f->h;
    return 1;
}

/* Go on to `until`, which lies clear of the configuration. */
static enum outcome come_to(struct phase *f, double until)
{
    const double place = f->at.place;
    enum outcome outcome = advance_to(f, until);
    outcome = outcome ? outcome : system_derivative(f->s, until, f->y1, f->dy);
    if (outcome)
        return outcome;
    f->t = until;
    memcpy(f->y, f->y1, (size_t)f->s->size * sizeof *f->y);
    f->at.place = place;
    return OUTCOME_DONE;
}

enum outcome come_beside_singularity(struct phase *f, const double *end, double t)
{
    const double whole = f->h, near = near_dependence(f);
    double error, length = fmax(CUT_LENGTH * whole, fabs(t - f->at.place) / CUT_REACH);
    while (length < whole && margin_at(f, end, f->at.place - MIDDLE * length) < near)
        length *= 2.0;
    const double begin = f->at.place - MIDDLE * length;
    const enum outcome outcome = begin > f->t ? come_to(f, begin) : OUTCOME_DONE;
    return outcome ? outcome : cut_step(f, t, length, &error);
}
