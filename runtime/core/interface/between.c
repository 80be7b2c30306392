/* States of a run between the rows of its record.
 *
 * A step of the run's method from the last row that is not later gives them, with the contacts that were held then. Beside a singular
 * configuration a step may take the wrong branch; the one back from the next row, which need not pass that place, then does not. The
 * nearer to the cubic through both rows is right. That misses a turn by an angle a by a^4/24 (part (1 - part))^2 at most;
 * what is off by more is looked at from both sides. Where contacts are held only the way on is taken: the way back has others. */
#include "interface/between.h"

#include "model/scales.h"
#include "motion/projection.h"

int take_between(struct ccgen_simulation *it, struct between *b)
{
    const struct system *s = &it->system;
    struct arena *arena = s->arena;
    const size_t contacts = s->model->contacts;
    *b = (struct between){
        .look = {.y = TAKE(arena, double, s->size),
                 .other = TAKE(arena, double, s->size),
                 .curve = TAKE(arena, double, s->n)},
        .latched = TAKE_ZEROS(arena, double, s->model->latches),
        .unit = TAKE(arena, double, 2 * (size_t)s->n + 1),
        .set = TAKE(arena, int, contacts),
        .mode = TAKE(arena, signed char, contacts),
    };
    return arena->ran_out;
}

/* How many of count times that never decrease are not later than t */
static size_t times_until(size_t count, const double *times, double t)
{
    size_t low = 0, high = count;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (times[middle] <= t)
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
    const size_t changes = times_until(modes->count, modes->t, t);
    b->count = 0;
    if (!changes)
        return;
    for (size_t k = modes->first[changes - 1]; k < modes->first[changes]; k++) {
        if (modes->mode[k] == IMPLIED && pushing)
            continue;
        b->set[b->count] = modes->contact[k];
        b->mode[b->count++] = modes->mode[k];
    }
}

void latched_at(const struct ccgen_simulation *it, struct between *b, double t)
{
    const size_t latches = it->system.model->latches;
    const size_t rows = times_until(it->run.record.count, it->run.record.t, t);
    if (latches)
        memcpy(b->latched, row_of(it, rows ? rows - 1 : 0) + it->system.size, latches * sizeof *b->latched);
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

/* Part of the way from the first row to the second */
static double part_of(const struct stretch *w, double t)
{
    return (t - w->t[0]) / (w->t[1] - w->t[0]);
}

/* On the line between both rows, put onto the closure, into y */
static enum outcome on_the_line(const struct stretch *w, double t, double *y)
{
    struct system s = *w->system;
    const size_t n = s.n;
    const double part = part_of(w, t);
    for (size_t i = 0; i < n; i++) {
        y[i] = w->q[0][i] + part * (w->q[1][i] - w->q[0][i]);
        y[n + i] = w->u[0][i] + part * (w->u[1][i] - w->u[0][i]);
    }
    s.active = NULL;
    const enum outcome outcome = project_position(&s, y);
    return outcome ? outcome : project_velocity(&s, y, y + n);
}

/* The cubic through both rows at the part of the way between them, into `curve`; the largest change of a coordinate between them */
static double draw_curve(const struct stretch *w, double part, double *curve)
{
    const size_t n = w->system->n;
    const double step = w->t[1] - w->t[0];
    double most = 0.0;
    for (size_t i = 0; i < n; i++) {
        const double change = w->q[1][i] - w->q[0][i];
        const double bend = part * w->u[1][i] * step - (1.0 - part) * w->u[0][i] * step + (1.0 - 2.0 * part) * change;
        curve[i] = w->q[0][i] + part * change + part * (part - 1.0) * bend;
        most = fmax(most, fabs(change));
    }
    return most;
}

static double off_curve(const double *curve, size_t n, const double *y)
{
    double most = 0.0;
    for (size_t i = 0; i < n; i++)
        most = fmax(most, fabs(y[i] - curve[i]));
    return most;
}

/* In flight: from the first row, and where that leads away from the curve, back from the second */
static enum outcome from_either(const struct stretch *w, const struct look *l, double t)
{
    const size_t n = w->system->n;
    const double part = part_of(w, t);
    const double most = draw_curve(w, part, l->curve);
    const double allowed = pow(part * (1.0 - part), 2.0) * pow(most, 4.0);
    const enum outcome onward = step_from(w, 0, t - w->t[0], l->y);
    if (!onward && off_curve(l->curve, n, l->y) <= allowed)
        return OUTCOME_DONE;
    const enum outcome back = step_from(w, 1, t - w->t[1], l->other);
    const double off = back ? INFINITY : off_curve(l->curve, n, l->other);
    if (!back && (onward || off <= allowed || off < off_curve(l->curve, n, l->y)))
        memcpy(l->y, l->other, w->system->size * sizeof *l->y);
    return onward && back ? back : OUTCOME_DONE;
}

enum outcome state_between(const struct stretch *w, const struct look *l, double t)
{
    int there_is;
    if (w->line)
        return on_the_line(w, t, l->y);
    const enum outcome outcome = step_by_singularity(w, t, l->y, &there_is);
    if (outcome == OUTCOME_INTERRUPTED || (there_is && !outcome))
        return outcome;
    return w->system->model->contacts ? step_from(w, 0, t - w->t[0], l->y) : from_either(w, l, t);
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

enum outcome state_at(const struct ccgen_simulation *it, struct between *b, double t, double *q, double *u)
{
    const struct record *record = &it->run.record;
    const size_t n = it->system.n, row = times_until(record->count, record->t, t) - 1;
    const double *y = row_of(it, row);
    enum outcome outcome = OUTCOME_DONE;
    if (t > record->t[row]) {
        struct system s = it->system;
        struct tolerance tolerance = it->run.tolerance;
        s.interruption = NULL;
        if (it->run.fixed_step != 0.0)
            tolerance.rtol = tolerance.atol = 0.0;
        held_at(it, b, record->t[row], 1);
        latched_at(it, b, record->t[row]);
        const double *behind = row_of(it, row + 1);
        const struct stretch w = {.system = &s,
                                  .method = it->run.method,
                                  .tolerance = tolerance,
                                  .drift = s.projects_steps ? DRIFT_PROJECTED
                                           : s.baumgarte    ? DRIFT_DAMPED
                                                            : DRIFT_LEFT,
                                  .t = {record->t[row], record->t[row + 1]},
                                  .q = {y, behind},
                                  .u = {y + n, behind + n},
                                  .line = on_a_line(it, row),
                                  .count = b->count,
                                  .set = b->set,
                                  .mode = b->mode,
                                  .latched = b->latched};
        outcome = state_between(&w, &b->look, t);
        y = b->look.y;
    }
    if (!outcome) {
        memcpy(q, y, n * sizeof *q);
        memcpy(u, y + n, n * sizeof *u);
    }
    return outcome;
}
