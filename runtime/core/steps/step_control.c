/* Step control; see step_control.h. */
#include "steps/step_control.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "base/tolerances.h"
#include "motion/derivative.h"
#include "steps/cut_step.h"
#include "steps/energy_guard.h"
#include "steps/singular_step.h"
#include "steps/step_end.h"

const double LEAST_CHANGE = 0.2;
static const double BEFORE_TURN = 0.9, SAFETY = 0.9, LARGEST_CHANGE = 6.0;
enum {
    AGAIN =
        4, /* times a step is taken anew for where it passes a singular configuration, or for the energy it misses there */
    MANY = 1000 /* steps, refused ones with them, for the way of one */
};

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

/* Put the end of a step back. What it had been meanwhile is kept where its derivative will be. Whether the step is to be taken
 * again, because of the place at which it passes a singular configuration, in *again; in *over whether by collocation, which leads there. */
static enum outcome project_and_place(struct phase *f, const double *error, int *again, int *over)
{
    double *end = f->dy1;
    memcpy(end, f->y1, (size_t)f->s->size * sizeof *end);
    const enum outcome back = project_step_end(f);
    *again = *over = 0;
    if (f->s->branch)
        return *error <= 1.0 ? back : OUTCOME_DONE;
    *again = f->at.passage == FREE || f->at.passage == ABOUT ? crosses_singularity(f, back, *error, end)
                                                             : !back && *error <= 1.0 && misplaced(f, end);
    *over = !*again && !back && leads_to_singularity(f);
    return *error <= 1.0 ? back : OUTCOME_DONE;
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

/* Hold the end of a step that is to be accepted to what its energy tells; *error is larger than 1 where that refuses it.
 *
 * A step past a singular configuration is given a wide tolerance there, for what no step can know; what its energy misses beyond that is an error of
 * the step, which a shorter one past the same place mends. Where a shorter one would end before it, the next begins nearer to it, where less
 * is known, and would be refused for that, and so on without end: that is done once for a place. */
static enum outcome hold_to_energy(struct phase *f, double *error, int *missed)
{
    double excess = 0.0;
    *error = fmax(*error, energy_residual(f));
    if (*error > 1.0)
        return OUTCOME_DONE;
    const enum outcome outcome = return_to_energy(f, f->h, &excess);
    if (outcome || !(excess > 1.0) || f->run->fixed_step > 0.0 || *missed >= AGAIN)
        return outcome;
    const int passes = passes_place(f, f->h * shorter(f, excess));
    if (passes || !f->at.nearer) {
        f->at.nearer |= !passes;
        ++*missed;
        *error = excess;
    }
    return OUTCOME_DONE;
}

/* The step cut off one past the singular configuration beside which it has to end, if there is one: *ends is set where that is taken, *tried where one was */
static enum outcome cut_off(struct phase *f, double allowed, int *tried, int *ends)
{
    if (!ends_beside_singularity(f, allowed))
        return OUTCOME_DONE;
    *tried = 1;
    const enum outcome outcome = end_beside_singularity(f, ends);
    f->run->steps += *ends;
    return outcome;
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

/* Follow the branch of the motion from here, unless that is known to lead nowhere: *leaves. */
static enum outcome try_to_follow(struct phase *f, int *leaves)
{
    if (*leaves || f->run->fixed_step > 0.0 || !f->branch.chart)
        return OUTCOME_DONE;
    const enum outcome outcome = follow_branch(f);
    *leaves = outcome == OUTCOME_NOT_CLOSED || outcome == OUTCOME_NO_BRANCH;
    return *leaves ? OUTCOME_DONE : outcome;
}

/* What the tries of a step have come to */
struct tries {
    double allowed, whole; /* length that the step may have, and of this try */
    int refused, again, missed, tried;
    int leaves;             /* whether no branch passes */
    enum passage elsewhere; /* how steps are taken away from a known place */
};

/* Begin a try: how it is taken, by its length; *ends where the step is taken already, cut off past a place. */
static enum outcome begin_step(struct phase *f, struct tries *now, int *ends)
{
    *ends = 0;
    if (!f->s->branch && now->elsewhere == FREE && begins_beside_singularity(f)) {
        const enum outcome outcome = try_to_follow(f, &now->leaves);
        if (outcome)
            return outcome;
        if (!f->s->branch)
            now->elsewhere = ABOUT;
        if (!f->s->branch || f->run->method->damps)
            take_over(f, f->h);
    }
    now->whole = f->h;
    if (f->s->branch)
        return OUTCOME_DONE;
    const enum outcome outcome = now->tried ? OUTCOME_DONE : cut_off(f, now->allowed, &now->tried, ends);
    if (!outcome && !*ends && f->h == now->whole)
        place_about_singularity(f, now->elsewhere);
    return outcome;
}

/* Put the end of a step back; *anew where the step is to be taken again for the place that it passes: along the branch of the motion, or, where none is told, placed about
 * it. */
static enum outcome end_step(struct phase *f, double *error, struct tries *now, int *anew)
{
    int places, over;
    const enum outcome back = project_and_place(f, error, &places, &over);
    const double own = now->whole * (*error > 1.0 ? shorter(f, *error) : 1.0);
    *anew = 0;
    if (!now->leaves && !f->s->branch && (places || over || ends_near_dependence(f))) {
        const enum outcome outcome = try_to_follow(f, &now->leaves);
        *anew = f->s->branch != NULL;
        if (outcome || *anew) {
            f->h = now->whole;
            if (*anew && f->passing && f->run->method->damps && !active_count(f->s))
                take_over(f, own);
            return outcome;
        }
    }
    *anew = (places || over) && now->again++ < AGAIN;
    if (!*anew)
        return back;
    if (f->at.passage == FREE)
        f->at.own = own;
    f->h = now->whole;
    if (over) {
        now->elsewhere = ABOUT;
        take_over(f, own);
    }
    return OUTCOME_DONE;
}

/* The step is accepted: how long the next may be */
static void accept(struct phase *f, double error, const struct tries *now, double *next)
{
    const double change = SAFETY * pow(fmax(error, 1e-12), -1.0 / f->by->order);
    *next = f->h * fmin(fmax(change, LEAST_CHANGE), now->refused ? 1.0 : LARGEST_CHANGE);
    if (f->at.passage == BEFORE)
        *next = fmax(*next, now->tried ? fmax(now->allowed, now->whole) : now->whole);
    else
        f->at.nearer = f->at.cuts = 0;
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
    struct tries now = {.allowed = *next,
                        .elsewhere = !outcome && !f->s->branch && keeps_collocation(f) ? ABOUT : FREE};
    while (!outcome) {
        double error = 0.0;
        int ends, anew = 0;
        outcome = begin_step(f, &now, &ends);
        if (ends || outcome)
            return outcome;
        outcome = measured_step(f, &error);
        if (outcome == OUTCOME_NOT_CLOSED && f->s->branch &&
            !(may_turn(f->s->branch) && f->run->fixed_step == 0.0 && LEAST_CHANGE * f->h >= shortest(f))) {
            outcome = take_closure(f);
            now.leaves = 1;
            f->h = now.whole;
            continue;
        }
        if (!outcome && isfinite(error))
            outcome = end_step(f, &error, &now, &anew);
        if (!outcome && anew)
            continue;
        outcome = outcome ? outcome : check_end(f, error);
        if (!outcome && error <= 1.0)
            outcome = hold_to_energy(f, &error, &now.missed);
        if (!outcome && error <= 1.0) {
            accept(f, error, &now, next);
            return OUTCOME_DONE;
        }
        if (outcome == OUTCOME_INTERRUPTED)
            return outcome;
        now.refused = 1;
        f->at.bounded = 0;
        run->rejected++;
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
    f->at.place = NAN;
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

int goes_in_one(const struct phase *f)
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
