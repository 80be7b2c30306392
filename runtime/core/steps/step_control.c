/* Step control; see step_control.h. */
#include "steps/step_control.h"

#include <math.h>
#include <string.h>

#include "base/tolerances.h"
#include "motion/derivative.h"
#include "steps/energy_guard.h"
#include "steps/singular_step.h"
#include "steps/step_end.h"

const double LEAST_CHANGE = 0.2;
static const double BEFORE_TURN = 0.9, SAFETY = 0.9, LARGEST_CHANGE = 6.0;
enum { MANY = 1000 /* steps, refused ones with them, for the way of one */ };

double first_step(struct phase *f)
{
    const int n = f->s->size;
    const struct tolerance tol = f->run->tolerance;
    double d0 = 0.0, d1 = 0.0, d2 = 0.0;
    for (int i = 0; i < n; i++) {
        const double scale = allowed_error(tol, i, fabs(f->y[i]));
        d0 += (f->y[i] / scale) * (f->y[i] / scale);
        d1 += (f->dy[i] / scale) * (f->dy[i] / scale);
    }
    d0 = sqrt(d0 / n);
    d1 = sqrt(d1 / n);
    const double time = f->s->time, least = 1e-12 * fmax(fabs(f->t), 1e-3 * time);
    const double h0 =
        fmin(d0 < 1e-5 || d1 * time < 1e-5 ? 1e-6 * time : fmax(0.01 * d0 / d1, least), next_stop(f->run, f->t) - f->t);
    for (int i = 0; i < n; i++)
        f->y1[i] = f->y[i] + h0 * f->dy[i];
    if (system_derivative(f->s, f->t + h0, f->y1, f->dy1))
        return h0;
    for (int i = 0; i < n; i++) {
        const double scale = allowed_error(tol, i, fabs(f->y[i]));
        d2 += ((f->dy1[i] - f->dy[i]) / scale) * ((f->dy1[i] - f->dy[i]) / scale);
    }
    d2 = sqrt(d2 / n) / h0;
    const double largest = fmax(d1 * time, d2 * time * time);
    const double h1 =
        largest <= 1e-15 ? fmax(1e-6 * time, 1e-3 * h0) : time * pow(0.01 / largest, 1.0 / f->run->method->order);
    return h1 > least ? fmin(100.0 * h0, h1) : least;
}

int outruns_velocity(const struct phase *f)
{
    double way = 0.0, speed = 0.0;
    for (int i = 0; i < f->s->n; i++) {
        way = fmax(way, fabs(f->y1[i] - f->y[i]) / f->s->unit[i]);
        speed = fmax(speed, fmax(fabs(f->y[f->s->n + i]), fabs(f->y1[f->s->n + i])) / f->s->unit[i]);
    }
    return f->run->fixed_step == 0.0 && way > OUTRUN * f->h * speed + LEAP;
}

double shortest(const struct phase *f)
{
    return SHORTEST * fmax(fabs(f->t), 1e-3 * f->s->time);
}

/* Part of its length that a step with this error is taken by again */
static double shorter(const struct phase *f, double error)
{
    return fmax(SAFETY * pow(error, -1.0 / f->by->order), LEAST_CHANGE);
}

/* The length after a step that failed: up to where a branch turns at a place that it passes by, if that is why, and is known */
static double shorter_before_place(const struct phase *f, enum outcome failed)
{
    const double until = failed == OUTCOME_NOT_CLOSED ? BEFORE_TURN * time_to_place(f->s, f->y + f->s->n) : 0.0;
    return until > LEAST_CHANGE * f->h && until < f->h ? until : LEAST_CHANGE * f->h;
}

/* A step of length f->h, and unless that is fixed its error */
static enum outcome measured_step(struct phase *f, double *error)
{
    const int fixed = f->run->fixed_step > 0.0;
    const enum outcome outcome = unprojected_step(f, f->h, fixed ? to_rounding(f->s) : f->run->tolerance);
    return outcome || fixed ? outcome : step_error(f, error);
}

/* Whether the end of the step is where its motion leads */
static enum outcome check_end(struct phase *f, double error)
{
    if (error <= 1.0 && outruns_velocity(f))
        return OUTCOME_NOT_CLOSED;
    return f->run->fixed_step > 0.0 && breaks_energy(f) ? OUTCOME_NOT_KEPT : OUTCOME_DONE;
}

/* Follow the branch of the motion from here; *leaves where none is told. */
static enum outcome try_to_follow(struct phase *f, int *leaves)
{
    const enum outcome outcome = follow_branch(f);
    *leaves = none_told(outcome);
    return *leaves ? OUTCOME_DONE : outcome;
}

/* Put the end of a step back; *anew where it is to be taken again along the branch of the motion, as it comes near dependence. */
static enum outcome end_step(struct phase *f, double error, double whole, int *leaves, int *anew)
{
    double *end = f->dy1; /* where its derivative will be */
    memcpy(end, f->y1, (size_t)f->s->size * sizeof *end);
    const enum outcome back = project_step_end(f);
    *anew = 0;
    if (*leaves || f->s->branch || !comes_near_dependence(f, back, error, end))
        return error <= 1.0 ? back : OUTCOME_DONE;
    const enum outcome outcome = try_to_follow(f, leaves);
    *anew = f->s->branch != NULL;
    if (*anew && f->passing && !active_count(f->s))
        take_over(f, whole * (error > 1.0 ? shorter(f, error) : 1.0));
    return outcome || *anew || error > 1.0 ? outcome : back;
}

/* The step is accepted: how long the next may be */
static void accept(struct phase *f, double error, int refused, double *next)
{
    const double change = SAFETY * pow(fmax(error, 1e-12), -1.0 / f->by->order);
    *next = f->h * fmin(fmax(change, LEAST_CHANGE), refused ? 1.0 : LARGEST_CHANGE);
    f->run->steps++;
}

/* Whether a step along a branch that leads to no place may be too long for it: the branch is told */
static int may_turn(const struct branch *b)
{
    return b->kind == PASSES_BY || b->comes_back > 0.0 || b->sampled;
}

enum outcome accepted_step(struct phase *f, double *next)
{
    struct run *run = f->run;
    enum outcome outcome = keep_following(f);
    int leaves = 0, refused = 0; /* whether no branch is told from here, and whether a try has failed */
    double least = INFINITY;     /* J that a longer try has missed of what is not known there */
    while (!outcome) {
        const double whole = f->h;
        double error = 0.0;
        outcome = measured_step(f, &error);
        if (outcome == OUTCOME_NOT_CLOSED && f->s->branch &&
            !(may_turn(f->s->branch) && run->fixed_step == 0.0 && LEAST_CHANGE * f->h >= shortest(f))) {
            outcome = take_closure(f);
            leaves = 1;
            continue;
        }
        if (!outcome && isfinite(error)) {
            int anew;
            outcome = end_step(f, error, whole, &leaves, &anew);
            if (!outcome && anew)
                continue;
        }
        outcome = outcome ? outcome : check_end(f, error);
        double unknown = 0.0;
        if (!outcome && error <= 1.0)
            error = fmax(error, energy_residual(f, &unknown));
        if (!outcome && error <= 1.0 && unknown > 0.0 && unknown < 0.5 * least && LEAST_CHANGE * f->h > shortest(f)) {
            least = unknown; /* it may be an error of the step all the same, of which a shorter one has less */
            error = INFINITY;
        }
        if (!outcome && error <= 1.0) {
            accept(f, error, refused, next);
            return OUTCOME_DONE;
        }
        if (outcome == OUTCOME_INTERRUPTED)
            return outcome;
        refused = 1;
        f->at.bounded = 0;
        run->rejected++;
        trace(&run->trace, (struct traced){f->t, f->h, error, TRACED_REFUSAL, -1, -1, -1, 0, outcome});
        f->h = outcome || !isfinite(error) ? shorter_before_place(f, outcome) : f->h * shorter(f, error);
        if (f->h < shortest(f) || run->fixed_step > 0.0)
            return outcome ? outcome : OUTCOME_STEP_TOO_SMALL;
        outcome = OUTCOME_DONE;
    }
    return outcome;
}

/* y1 at the time `until`, by as many steps as the tolerance asks for */
static enum outcome integrate_to(struct phase *f, double until)
{
    const struct run *run = f->run;
    double next = until - f->t;
    while (f->t < until) {
        if (run->steps + run->rejected > MANY)
            return OUTCOME_BUDGET;
        const double left = until - f->t;
        f->h = 1.01 * next >= left ? left : next;
        f->at.bounded = f->h == left;
        f->at.longest = left;
        enum outcome outcome = accepted_step(f, &next);
        if (outcome || f->h == left)
            return outcome;
        if ((outcome = evaluate_end_derivative(f)))
            return outcome;
        f->t += f->h;
        f->at.energy_known = 0;
        memcpy(f->y, f->y1, (size_t)f->s->size * sizeof *f->y);
        memcpy(f->dy, f->dy1, (size_t)f->s->size * sizeof *f->dy);
    }
    return OUTCOME_DONE;
}

/* Whether the way between two rows is one step: no tolerance is given, or the method estimates nothing, or contacts or kinks may have ended it */
static int goes_in_one(const struct phase *f)
{
    const struct ccgen_model *m = f->s->model;
    return m->contacts || m->switches || f->run->tolerance.rtol == 0.0 || !estimates_errors(f->run->method);
}

enum outcome advance_to(struct phase *f, double until)
{
    enum outcome outcome = f->s->branch ? OUTCOME_DONE : follow_if_beside(f);
    if (!outcome || outcome == OUTCOME_NO_BRANCH)
        outcome = until < f->t || goes_in_one(f) ? projected_step(f, until - f->t) : integrate_to(f, until);
    leave_branch(f);
    return outcome;
}
