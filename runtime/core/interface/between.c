/* States of a run between the rows of its record.
 *
 * A step of the run's method from the last row that is not later gives them, with the contacts that were held then. Beside a singular
 * configuration a step may take the wrong branch; the one back from the next row, which need not pass that place, then does not. The
 * nearer to the cubic through both rows is right. That misses a turn by an angle a by a^4/24 (part (1 - part))^2 at most;
 * what is off by more is looked at from both sides. Where contacts are held only the way on is taken: the way back has others. */
#include "interface/between.h"

#include "methods/gauss.h"
#include "model/scales.h"
#include "motion/projection.h"

int take_between(struct ccgen_simulation *it, struct between *b)
{
    const struct system *s = &it->system;
    struct arena *arena = s->arena;
    const size_t contacts = s->model->contacts;
    *b = (struct between){
        .y = TAKE(arena, double, s->size),
        .other = TAKE(arena, double, s->size),
        .curve = TAKE(arena, double, s->n),
        .latched = TAKE_ZEROS(arena, double, s->model->latches),
        .unit = TAKE(arena, double, 2 * (size_t)s->n + 1),
        .set = TAKE(arena, int, contacts),
        .mode = TAKE(arena, signed char, contacts),
        .weight = TAKE(arena, double, contacts),
    };
    return arena->ran_out;
}

/* How many of count times that never decrease are not later than t, or, where `before`, are earlier */
static size_t times_until(size_t count, const double *times, double t, int before)
{
    size_t low = 0, high = count;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (before ? times[middle] < t : times[middle] <= t)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

static const double *row_of(const struct ccgen_simulation *it, size_t row)
{
    return it->run.record.y + row * (it->system.size + it->system.model->latches);
}

void held_at(const struct ccgen_simulation *it, struct between *b, double t, int pushing)
{
    const struct mode_history *modes = &it->run.modes;
    const size_t changes = times_until(modes->count, modes->t, t, 0);
    b->count = 0;
    if (!changes)
        return;
    for (size_t k = modes->first[changes - 1]; k < modes->first[changes]; k++) {
        const int carried = modes->mode[k] == IMPLIED;
        if (carried && pushing)
            continue;
        b->set[b->count] = modes->contact[k];
        b->mode[b->count] = carried ? FRICTIONLESS : modes->mode[k];
        b->weight[b->count++] = modes->weight[k];
    }
}

/* What effects held from the row before t on, or where t is a row's time and `before`, until it */
static void latched_from(const struct ccgen_simulation *it, struct between *b, double t, int before)
{
    const size_t latches = it->system.model->latches;
    const size_t rows = times_until(it->run.record.count, it->run.record.t, t, before);
    if (latches)
        memcpy(b->latched, row_of(it, rows ? rows - 1 : 0) + it->system.size, latches * sizeof *b->latched);
}

void latched_at(const struct ccgen_simulation *it, struct between *b, double t)
{
    latched_from(it, b, t, 0);
}

int stepped_at(const struct ccgen_simulation *it, double t)
{
    const struct stepping *stepping = &it->run.stepping;
    for (size_t i = 0; i < stepping->count; i++)
        if (stepping->last[i] > stepping->first[i] && t >= stepping->t0[i] &&
            (t < stepping->t1[i] || stepping->last[i] == it->run.record.count - 1))
            return 1;
    return 0;
}

/* A step of length h from a row at t0 whose state is q, u: into y */
static enum outcome step_from(const struct ccgen_simulation *it, struct between *b, double t0, const double *q,
                              double h, double *y)
{
    const struct run *run = &it->run;
    const struct method *ways[] = {run->method, &gauss};
    struct tolerance tolerance = run->tolerance;
    const enum drift drift = it->system.projects_steps ? DRIFT_PROJECTED
                             : it->system.baumgarte    ? DRIFT_DAMPED
                                                       : DRIFT_LEFT;
    enum outcome outcome = OUTCOME_UNKNOWN_METHOD;
    if (run->fixed_step != 0.0)
        tolerance.rtol = tolerance.atol = 0.0;
    held_at(it, b, t0, 1);
    latched_from(it, b, t0, h < 0.0);
    for (int way = 0; way < 2 && outcome; way++) {
        struct system s = it->system;
        s.interruption = NULL;
        memcpy(y, q, 2 * (size_t)s.n * sizeof *y);
        memset(y + 2 * s.n, 0, (size_t)(s.size - 2 * s.n) * sizeof *y);
        outcome = advance(&s, ways[way], tolerance, drift, t0, h, b->count, b->set, b->mode, b->latched, y);
        if (ways[way] == &gauss)
            break;
    }
    return outcome;
}

/* The row of a stretch of time stepping that t is in lies before it on a line: whether t is in one */
static int on_a_line(const struct ccgen_simulation *it, size_t row)
{
    const struct stepping *stepping = &it->run.stepping;
    const double *t = it->run.record.t;
    for (size_t i = 0; i < stepping->count; i++)
        if (t[stepping->first[i]] <= t[row] && t[row] < t[stepping->last[i]])
            return 1;
    return 0;
}

/* On the line between a row and the next, put onto the closure */
static enum outcome between_steps(const struct ccgen_simulation *it, size_t row, double t, double *q, double *u)
{
    struct system s = it->system;
    const size_t n = s.n;
    const double *from = row_of(it, row), *to = row_of(it, row + 1), *times = it->run.record.t;
    const double part = (t - times[row]) / (times[row + 1] - times[row]);
    for (size_t i = 0; i < n; i++) {
        q[i] = from[i] + part * (to[i] - from[i]);
        u[i] = from[n + i] + part * (to[n + i] - from[n + i]);
    }
    s.interruption = NULL;
    s.active = NULL;
    const enum outcome outcome = project_position(&s, q);
    return outcome ? outcome : project_velocity(&s, q, u);
}

/* The cubic through a row and the next at the part of the way between them, into b->curve; the largest change of a coordinate
 * between them */
static double draw_curve(const struct ccgen_simulation *it, struct between *b, size_t row, double part)
{
    const size_t n = it->system.n;
    const double *from = row_of(it, row), *to = row_of(it, row + 1);
    const double step = it->run.record.t[row + 1] - it->run.record.t[row];
    double most = 0.0;
    for (size_t i = 0; i < n; i++) {
        const double change = to[i] - from[i];
        const double bend = part * to[n + i] * step - (1.0 - part) * from[n + i] * step + (1.0 - 2.0 * part) * change;
        b->curve[i] = from[i] + part * change + part * (part - 1.0) * bend;
        most = fmax(most, fabs(change));
    }
    return most;
}

static double off_curve(const struct between *b, size_t n, const double *y)
{
    double most = 0.0;
    for (size_t i = 0; i < n; i++)
        most = fmax(most, fabs(y[i] - b->curve[i]));
    return most;
}

/* In flight: from the row, and where that leads away from the curve, back from the next one */
static enum outcome from_either(const struct ccgen_simulation *it, struct between *b, size_t row, double t)
{
    const double *times = it->run.record.t;
    const size_t n = it->system.n;
    const double part = (t - times[row]) / (times[row + 1] - times[row]);
    const double most = draw_curve(it, b, row, part);
    const double allowed = pow(part * (1.0 - part), 2.0) * pow(most, 4.0);
    const enum outcome onward = step_from(it, b, times[row], row_of(it, row), t - times[row], b->y);
    if (!onward && off_curve(b, n, b->y) <= allowed)
        return OUTCOME_DONE;
    const enum outcome back = step_from(it, b, times[row + 1], row_of(it, row + 1), t - times[row + 1], b->other);
    if (!back && (onward || off_curve(b, n, b->other) <= allowed || off_curve(b, n, b->other) < off_curve(b, n, b->y)))
        memcpy(b->y, b->other, it->system.size * sizeof *b->y);
    return onward && back ? back : OUTCOME_DONE;
}

enum outcome state_at(const struct ccgen_simulation *it, struct between *b, double t, double *q, double *u)
{
    const struct record *record = &it->run.record;
    const size_t n = it->system.n, row = times_until(record->count, record->t, t, 0) - 1;
    const double *y = row_of(it, row);
    enum outcome outcome = OUTCOME_DONE;
    if (t > record->t[row]) {
        if (on_a_line(it, row))
            return between_steps(it, row, t, q, u);
        outcome = it->system.model->contacts ? step_from(it, b, record->t[row], y, t - record->t[row], b->y)
                                             : from_either(it, b, row, t);
        y = b->y;
    }
    if (!outcome) {
        memcpy(q, y, n * sizeof *q);
        memcpy(u, y + n, n * sizeof *u);
    }
    return outcome;
}
