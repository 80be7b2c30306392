/* Steps that are put back whatever their error, and what one past a singular configuration gets wrong, taken back (docs/theory, eq. 8.6).
 *
 * Of the velocities by which rows that become dependent would part, passing them at the distance sigma leaves rounding / sigma^2
 * unknown, and all of it lies along one motion: that which impulses in those rows cause where they are passed. From there on it goes along
 * with the motion, and turns into energy. The energy itself is known to rounding, as it is a sum: where nothing but masses and potentials has
 * any, what it misses at the end says how much of that motion is there. This is a projection onto an invariant (E. Hairer, C. Lubich,
 * G. Wanner, Geometric Numerical Integration, 2006, section IV.4) along the one direction that is not known, and so less
 * of an error, not another one.
 */
#include "steps/step_end.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "base/tolerances.h"
#include "constraints/impulse.h"
#include "constraints/nullspace.h"
#include "motion/projection.h"
#include "steps/singular_step.h"

/* What the place at which rows are passed is looked at by */
struct passing {
    double *q, *rates;  /* [n], [rows + drives] */
    double *one, *both; /* [n] motions: on one side of it, and of both sides */
    double *end;        /* [size] an end that is moved by all that is unknown */
};

static enum outcome take_passing(const struct system *s, struct passing *p)
{
    const size_t n = s->n, size = s->size;
    p->q = TAKE(s->arena, double, n);
    p->rates = TAKE(s->arena, double, (s->model->rows + s->model->drives));
    p->one = TAKE(s->arena, double, n);
    p->both = TAKE_ZEROS(s->arena, double, n);
    p->end = TAKE(s->arena, double, size);
    return s->arena->ran_out ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
}

/* Motion one[n], of size 1 in units, that impulses in the rows that become dependent cause at part x of the step; whether there is one */
static int parting_motion(struct phase *f, double h, double x, struct passing *p)
{
    struct system *s = f->s;
    between_ends(f, h, f->y1, x, p->q);
    if (!nearly_lost_rates(s, p->q, p->rates) || system_correction(s, p->q, 0, p->rates, RANK_TOLERANCE, p->one))
        return 0;
    const double size = fastest(s, p->one);
    for (int i = 0; i < s->n; i++)
        p->one[i] /= size;
    return size > 0.0 && isfinite(size);
}

/* Motion both[n], the mean of those on either side of the place, which itself has none: stages are no nearer to it. */
static int motion_of_both_sides(struct phase *f, double h, double part, struct passing *p)
{
    const int n = f->s->n;
    for (int side = -1; side <= 1; side += 2) {
        if (!parting_motion(f, h, fmin(fmax(part + side * PLACED, PLACED), 1.0), p))
            return 0;
        double along = 0.0;
        for (int i = 0; i < n; i++)
            along += p->both[i] * p->one[i] / (f->s->unit[i] * f->s->unit[i]);
        for (int i = 0; i < n; i++)
            p->both[i] += along < 0.0 ? -0.5 * p->one[i] : 0.5 * p->one[i];
    }
    return 1;
}

/* The end of the step, moved by all that is unknown: velocities by `by`, places by what that makes of them since part x. */
static enum outcome move_end(struct phase *f, double h, double x, double by, struct passing *p)
{
    const int n = f->s->n;
    memcpy(p->end, f->y1, (size_t)f->s->size * sizeof *p->end);
    for (int i = 0; i < n; i++) {
        p->end[i] += (1.0 - x) * h * by * p->both[i];
        p->end[n + i] += by * p->both[i];
    }
    const enum outcome outcome = project_position(f->s, p->end);
    return outcome ? outcome : project_velocity(f->s, p->end, p->end + n);
}

/* J: of it what is in motion, and what it is known to */
struct energy {
    double all, moves, noise;
};

static struct energy energy_at(const struct system *s, const double *y)
{
    double e[2];
    s->model->energy(s->k, y, y + s->n, e);
    return (struct energy){e[0] + e[1], e[0], ENERGY_ROUNDING * (e[0] + fabs(e[1]))};
}

/* Of all that is unknown the part, -1 to 1, that is most likely where moving by all of it gains `all` (J), the end has gained `gain`, and energies are
 * known to `noise`: least squares of both. */
static double most_likely(double gain, double all, double noise)
{
    const double part = -gain * all / (all * all + noise * noise);
    return isfinite(part) ? fmax(-1.0, fmin(part, 1.0)) : 0.0;
}

/* The same, once the motion is found; `unknown` is the part of the velocities that was unknown at the beginning. */
static enum outcome return_along_motion(struct phase *f, double h, double part, double unknown, struct passing *p,
                                        double *excess)
{
    struct system *s = f->s;
    const double speed = fastest(s, f->y1 + s->n);
    enum outcome outcome = project_velocity(s, f->y1, p->both);
    const double left = fastest(s, p->both), first_order = sqrt(DBL_EPSILON) / left; /* the square of it is rounding */
    outcome = outcome ? outcome : move_end(f, h, part, fmin(unknown, first_order) * speed, p);
    if (outcome)
        return outcome;
    const struct energy begin = energy_at(s, f->y), end = energy_at(s, f->y1), moved = energy_at(s, p->end);
    const double gain = end.all - begin.all, all = moved.all - end.all, by = most_likely(gain, all, begin.noise);
    for (int i = 0; i < 2 * s->n && by != 0.0; i++)
        f->y1[i] += by * (p->end[i] - f->y1[i]);
    *excess = fabs(gain + by * all) / (KEPT * f->run->tolerance.rtol * begin.moves + begin.noise);
    if (f->at.energy_h == h)
        s->model->energy(s->k, f->y1, f->y1 + s->n, f->at.energy_end);
    return OUTCOME_DONE;
}

enum outcome return_to_energy(struct phase *f, double h, double *excess)
{
    struct system *s = f->s;
    *excess = 0.0;
    const double part = fmax(0.0, (f->at.place - f->t) / h);
    if (f->at.passage != ACROSS || s->model->power || active_count(s) || !(h > 0.0 && part < 1.0))
        return OUTCOME_DONE;
    const struct mark mark = s->arena->top;
    struct passing p;
    enum outcome outcome = take_passing(s, &p);
    if (!outcome && motion_of_both_sides(f, h, part, &p))
        outcome = return_along_motion(f, h, part, unknown_velocity(f), &p, excess);
    give_back(s->arena, mark);
    return outcome == OUTCOME_INTERRUPTED || outcome == OUTCOME_NO_MEMORY ? outcome : OUTCOME_DONE; /* it stays else */
}

/* Step of length h, put back onto the closure whatever its error. What a method iterates goes to rounding, so that y1 is a smooth
 * function of h: landing on an event needs that. */
static enum outcome step_put_back(struct phase *f, double h)
{
    const struct tolerance tolerance = f->run->tolerance, little = {.rtol = ITERATED * tolerance.rtol,
                                                                    .atol = ITERATED * tolerance.atol,
                                                                    .unit = tolerance.unit};
    enum outcome outcome = unprojected_step(f, h, to_rounding(f->s));
    if (outcome == OUTCOME_NO_CONVERGENCE && little.rtol > 0.0 &&
        estimates_errors(f->by)) { /* loads that all but cancel have a rounding of their own */
        double error = INFINITY;
        outcome = unprojected_step(f, h, little);
        outcome = outcome ? outcome : step_error(f, &error);
        outcome = outcome || error <= 1.0 ? outcome : OUTCOME_NO_CONVERGENCE;
    }
    return outcome ? outcome : project_step_end(f);
}

enum outcome projected_step(struct phase *f, double h)
{
    enum outcome outcome = step_put_back(f, h);
    if (!outcome && f->at.passage == FREE && f->run->fixed_step == 0.0 && !f->s->branch && ends_near_dependence(f)) {
        outcome = follow_branch(f); /* it was to end elsewhere, where nothing told of the place */
        if (f->s->branch && !outcome)
            outcome = step_put_back(f, h);
        if (outcome == OUTCOME_NOT_CLOSED || outcome == OUTCOME_NO_BRANCH) {
            outcome = take_closure(f);
            outcome = outcome ? outcome : step_put_back(f, h);
        }
    }
    double excess;
    return outcome ? outcome : return_to_energy(f, h, &excess);
}
