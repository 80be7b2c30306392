/* One step of a smooth phase; see step.h. */
#include "steps/step.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "base/tolerances.h"
#include "constraints/nullspace.h"
#include "constraints/onto_branch.h"
#include "constraints/place.h"
#include "constraints/rows.h"
#include "motion/derivative.h"
#include "motion/projection.h"

double rest_speed(const struct phase *f)
{
    return fmax(REST_SPEED, f->at.slow);
}

double rest_velocity(const struct phase *f, int contact)
{
    const double speed = f->s->restitution[contact] < 1.0 ? rest_speed(f) : REST_SPEED;
    return speed * f->s->extent[contact] / f->s->time;
}

void note_rest(struct phase *f, int contact, double rate)
{
    if (f->at.slow > 0.0)
        f->run->rest_speed = fmax(f->run->rest_speed, fabs(rate) / f->s->extent[contact] * f->s->length);
}

int may_rest(const struct phase *f, int contact, double rate)
{
    return f->s->restitution[contact] < 1.0 && fabs(rate) <= f->at.seen * f->s->extent[contact] / f->s->time;
}

double gap_tolerance(const struct phase *f, int contact)
{
    return fmin(fmax(f->run->tolerance.rtol, FINEST_GAP), COARSEST_GAP) * f->s->extent[contact];
}

enum outcome evaluate_derivative(struct phase *f)
{
    return system_derivative(f->s, f->t, f->y, f->dy);
}

int projects(const struct phase *f)
{
    return active_count(f->s) || (f->s->rows_on && f->s->projects_steps);
}

/* Whether driven joints are at place[drives] and have speed[drives] still */
static enum outcome check_driven(const struct phase *f, const double *place, const double *speed)
{
    const struct ccgen_model *m = f->s->model;
    const double *unit = f->s->unit, *unit_of_speed = unit + f->s->n;
    double fast = 1.0;
    for (int d = 0; d < m->drives; d++)
        fast = fmax(fast, fabs(speed[d]) / unit_of_speed[m->driven[2 * d]]);
    for (int d = 0; d < m->drives; d++)
        if (fabs(driven_by(m, d, f->y1) - place[d]) > DRIVEN * unit[m->driven[2 * d]] ||
            fabs(driven_by(m, d, f->y1 + f->s->n) - speed[d]) > DRIVEN * fast * unit_of_speed[m->driven[2 * d]])
            return OUTCOME_NOT_CLOSED;
    return OUTCOME_DONE;
}

enum outcome project_step_end(struct phase *f)
{
    const struct ccgen_model *m = f->s->model;
    const int n = f->s->n;
    if (!projects(f))
        return OUTCOME_DONE;
    const struct mark mark = f->s->arena->top;
    double *place = TAKE(f->s->arena, double, m->drives), *speed = TAKE(f->s->arena, double, m->drives);
    enum outcome outcome = f->s->arena->ran_out ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    for (int d = 0; d < m->drives && !outcome; d++) {
        place[d] = driven_by(m, d, f->y1);
        speed[d] = driven_by(m, d, f->y1 + n);
    }
    outcome = outcome ? outcome : project_state(f->s, f->y1, f->y1 + n);
    outcome = outcome ? outcome : check_driven(f, place, speed);
    give_back(f->s->arena, mark);
    return outcome;
}

enum outcome take_closure(struct phase *f)
{
    leave_branch(f);
    return f->branch.begins.margin < BRIDGED ? evaluate_derivative(f) : OUTCOME_DONE;
}

enum outcome follow_branch(struct phase *f)
{
    struct system *s = f->s;
    s->branch = NULL;
    f->at.follows = 0;
    enum outcome outcome = begin_branch(s, &f->branch, f->y, f->y + s->n);
    if (outcome)
        return outcome;
    s->branch = &f->branch;
    f->at.follows = 1;
    if (f->branch.begins.margin < BRIDGED) {
        outcome = evaluate_derivative(f);
        if (outcome && outcome != OUTCOME_INTERRUPTED && outcome != OUTCOME_NO_MEMORY && outcome != OUTCOME_TWO_LINES)
            outcome = take_closure(f) == OUTCOME_INTERRUPTED ? OUTCOME_INTERRUPTED : OUTCOME_NOT_CLOSED;
    }
    return outcome;
}

int none_told(enum outcome outcome)
{
    return outcome == OUTCOME_NOT_CLOSED || outcome == OUTCOME_NO_BRANCH;
}

int is_beside_place(struct phase *f, const double *y)
{
    const int rank = f->branch.rank ? f->branch.rank : f->s->rows_on;
    const double margin = closure_margin(f->s, y, rank), seen = f->at.widest;
    f->at.widest = fmax(seen, margin);
    return margin < BRIDGED && margin < (seen > 0.0 ? SIGMA_DROP_COARSE * f->at.widest : SIGMA_DROP * BRIDGED);
}

/* What impacts and steps in time leave beside a place lies on the closure to rounding / sigma^2 only: put it there. */
static enum outcome put_start_onto_branch(struct phase *f)
{
    const size_t n = f->s->n;
    const struct mark mark = f->s->arena->top;
    double *there = TAKE(f->s->arena, double, 2 * n);
    enum outcome outcome = f->s->arena->ran_out ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    if (!outcome) {
        memcpy(there, f->y, 2 * n * sizeof *there);
        outcome = project_state(f->s, there, there + n);
    }
    if (!outcome) {
        memcpy(f->y, there, 2 * n * sizeof *there);
        outcome = evaluate_derivative(f);
    }
    give_back(f->s->arena, mark);
    return !outcome || outcome == OUTCOME_INTERRUPTED || outcome == OUTCOME_NO_MEMORY || outcome == OUTCOME_TWO_LINES
               ? outcome
               : OUTCOME_NOT_CLOSED;
}

enum outcome follow_if_beside(struct phase *f)
{
    leave_branch(f);
    if (!f->branch.chart || !is_beside_place(f, f->y))
        return OUTCOME_DONE;
    enum outcome outcome = follow_branch(f);
    if (f->branch.begins.margin >= BRIDGED) /* rows that depend everywhere */
        leave_branch(f);
    if (outcome == OUTCOME_NOT_CLOSED) {
        leave_branch(f);
        return OUTCOME_DONE;
    }
    if (!outcome && passes_by(f->s) && (outcome = put_start_onto_branch(f)) == OUTCOME_NOT_CLOSED)
        outcome = take_closure(f);
    return outcome;
}

enum outcome decide_on_branch(struct phase *f)
{
    const int follows = f->at.follows;
    if (!follows && f->run->steps)
        return OUTCOME_DONE;
    const enum outcome outcome = follow_if_beside(f);
    f->at.follows = follows;
    return outcome == OUTCOME_NO_BRANCH ? OUTCOME_DONE : outcome;
}

enum outcome strike_on_branch(struct phase *f)
{
    if (!f->at.follows || !f->branch.chart || !is_beside_place(f, f->y))
        return OUTCOME_DONE;
    const enum outcome outcome = follow_branch(f);
    if (!outcome && (goes_through_crossing(f->s) || (passes_by(f->s) && f->branch.begins.margin < BRIDGED)))
        read_state_on_branch(f->s, f->y, f->y + f->s->n);
    else
        f->s->branch = NULL;
    f->at.follows = 1;
    return none_told(outcome) ? OUTCOME_DONE : outcome;
}

enum outcome keep_following(struct phase *f)
{
    f->s->branch = NULL;
    if (!f->at.follows || !f->branch.chart) {
        leave_branch(f);
        return OUTCOME_DONE;
    }
    if (closure_margin(f->s, f->y, f->branch.rank) >=
        BRIDGED) { /* a step that comes there again is found as the first was */
        forget_place(f->s, &f->branch);
        leave_branch(f);
        return OUTCOME_DONE;
    }
    const enum outcome outcome = follow_branch(f);
    return none_told(outcome) ? OUTCOME_DONE : outcome;
}

void leave_branch(struct phase *f)
{
    f->s->branch = NULL;
    f->at.follows = 0;
}

enum outcome unprojected_step(struct phase *f, double h, struct tolerance tolerance)
{
    const int follows = f->s->branch != NULL;
    const int other = follows && f->passing;
    f->by = other ? &gauss : f->run->method;
    f->steps = other ? f->passing : f->scratch;
    if (other) {
        gauss.restart(f->passing, f->s->size);
        if (f->run->method->restart)
            f->run->method->restart(f->scratch, f->s->size);
    }
    if (follows)
        rewind_branch(&f->branch);
    return f->by->step(f->s, f->steps, f->t, h, tolerance, f->y, f->dy, f->y1);
}

enum outcome evaluate_end_derivative(struct phase *f)
{
    return f->run->method->derivatives || f->by != f->run->method ? system_derivative(f->s, f->t + f->h, f->y1, f->dy1)
                                                                  : OUTCOME_DONE;
}

enum { ROUNDINGS = 16 };

double missed_velocity(const struct phase *f)
{
    return passes_by(f->s) ? ROUNDINGS * DBL_EPSILON / nearest_margin(f->s) : 0.0;
}

/* The tolerance of the step, and of what it begins with */
static struct tolerance tolerance_of(const struct phase *f)
{
    struct tolerance tolerance = f->run->tolerance;
    if (f->by == &gauss && f->s->branch) {
        tolerance.rtol *= GUIDED;
        tolerance.atol *= GUIDED;
    }
    tolerance.atol = fmax(tolerance.atol, missed_velocity(f) * fastest(f->s, f->y + f->s->n) * f->s->time);
    if (passes_by(f->s)) {
        tolerance.places = f->s->n;
        tolerance.nearer = fmin(fmax(nearest_margin(f->s), ROUNDINGS * DBL_EPSILON / tolerance.rtol), 1.0);
    }
    return tolerance;
}

enum outcome step_error(struct phase *f, double *error)
{
    const struct method *method = f->by;
    const struct tolerance tolerance = tolerance_of(f);
    const int n = f->s->n, size = f->s->size;
    *error = INFINITY; /* of an end that is not finite; errors divided by its size would be 0, or no number */
    for (int i = 0; i < size; i++)
        if (!isfinite(f->y1[i]))
            return OUTCOME_DONE;
    *error = method->measure(f->steps, size, tolerance, f->y, f->y1);
    if (!projects(f) || !f->s->rows_on || !(*error > 1.0 && isfinite(*error)))
        return OUTCOME_DONE; /* across contacts alone an error is one: one that is passed may have jumped */
    int count;
    double *estimates = method->estimates(f->steps, size, &count);
    const struct mark mark = f->s->arena->top;
    double *there = TAKE(f->s->arena, double, 2 * (size_t)n);
    enum outcome outcome = f->s->arena->ran_out ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    if (!outcome)
        memcpy(there, f->y1, 2 * (size_t)n * sizeof *there);
    const int follows = !outcome && follows_at(f->s, there);
    if (follows)
        outcome = put_onto_branch(f->s, there, there + n);
    for (int i = 0; i < 2 * count && !outcome; i++) { /* of the coordinates, then of the velocities */
        double *estimate = estimates + (size_t)(i / 2) * size + i % 2 * n;
        outcome =
            follows ? keep_velocities_along_branch(f->s, there, estimate) : project_velocity(f->s, there, estimate);
    }
    give_back(f->s->arena, mark);
    if (outcome)
        return outcome;
    const double left = f->s->branch ? 0.0 : BELIEVED * *error;
    *error = fmax(left, method->measure(f->steps, size, tolerance, f->y, f->y1));
    return OUTCOME_DONE;
}

int record_state(struct phase *f)
{
    const struct record *r = &f->run->record;
    const size_t size = f->s->size, width = row_width(f->s);
    if (r->count && r->t[r->count - 1] == f->t && !memcmp(r->y + (r->count - 1) * width, f->y, size * sizeof *f->y))
        return 0;
    return append_row(&f->run->record, f->t, f->y, size, f->latched, width - size);
}

void record_latches(struct phase *f)
{
    const struct record *r = &f->run->record;
    const size_t size = f->s->size, width = row_width(f->s);
    if (width > size && r->count && r->t[r->count - 1] == f->t)
        memcpy(r->y + (r->count - 1) * width + size, f->latched, (width - size) * sizeof *f->latched);
}

size_t row_width(const struct system *s)
{
    return (size_t)s->size + s->model->latches;
}

double next_kink(const struct run *run, double t)
{
    size_t low = 0, high = run->stop_count; /* stops before low are not after t, those from high on are */
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (run->stops[middle] <= t)
            low = middle + 1;
        else
            high = middle;
    }
    return low < run->stop_count ? run->stops[low] : INFINITY;
}

double next_stop(const struct run *run, double t)
{
    return fmin(next_kink(run, t), run->until);
}
