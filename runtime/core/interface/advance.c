/* Steps from rows of a record: for states between them. */
#include "interface/advance.h"

#include <math.h>
#include <string.h>

#include "base/tolerances.h"
#include "constraints/branch.h"
#include "methods/gauss.h"
#include "steps/kinks.h"
#include "steps/look.h"
#include "steps/phase.h"
#include "steps/step_control.h"

/* What goes on from a row, with a system and a run of its own */
struct advance {
    struct system s;
    struct run run;
    struct phase f;
    struct mark mark;
};

static void write_row(const struct stretch *w, int end, double *y)
{
    const size_t n = w->system->n;
    memcpy(y, w->q[end], n * sizeof *y);
    memcpy(y + n, w->u[end], n * sizeof *y);
    memset(y + 2 * n, 0, (w->system->size - 2 * n) * sizeof *y);
}

static enum outcome begin_at(const struct stretch *w, const struct method *method, int end, double h, struct advance *a)
{
    a->s = *w->system;
    struct system *s = &a->s;
    s->branch = NULL;
    a->run = (struct run){.method = method, .tolerance = w->tolerance};
    a->run.tolerance.unit = s->unit;
    a->f = (struct phase){.s = s, .run = &a->run, .t = w->t[end]};
    a->mark = s->arena->top;
    keep_closed(s, w->drift);
    if (!method->step)
        return OUTCOME_UNKNOWN_METHOD;
    if (take_phase(&a->f))
        return OUTCOME_NO_MEMORY;
    if (w->count)
        activate(&a->f.active, w->count, w->set, w->mode);
    write_row(w, end, a->f.y);
    if (s->model->latches)
        memcpy(a->f.latched, w->latched, s->model->latches * sizeof *w->latched);
    const enum outcome outcome = hold_sides(&a->f, h < 0.0 ? -1 : 1);
    return outcome ? outcome : evaluate_derivative(&a->f);
}

/* The end of the step that was taken into y[size], if there is one */
static void end_advance(struct advance *a, enum outcome outcome, double *y)
{
    if (!outcome)
        memcpy(y, a->f.y1, (size_t)a->s.size * sizeof *y);
    give_back(a->s.arena, a->mark);
}

static enum outcome advance(const struct stretch *w, const struct method *method, int end, double h, double *y)
{
    struct advance a;
    enum outcome outcome = begin_at(w, method, end, h, &a);
    outcome = outcome ? outcome : advance_to(&a.f, a.f.t + h);
    end_advance(&a, outcome, y);
    return outcome;
}

enum outcome step_from(const struct stretch *w, int end, double h, double *y)
{
    const enum outcome outcome = advance(w, w->method, end, h, y);
    const int last = !outcome || outcome == OUTCOME_INTERRUPTED || w->method == &gauss;
    return last ? outcome : advance(w, &gauss, end, h, y);
}

/* From a row of the stretch, along the branch on which the motion is there */
static enum outcome step_along_branch(const struct stretch *w, int end, double t, double *y)
{
    struct advance a;
    enum outcome outcome = begin_at(w, w->method, end, t - w->t[end], &a);
    outcome = outcome ? outcome : look_along_branch(&a.f, t);
    end_advance(&a, outcome, y);
    return outcome;
}

/* Whether the stretch begins and ends at rest at one place: so it rests between */
static int stands(const struct stretch *w)
{
    const struct system *s = w->system;
    int elsewhere = moves(s, w->u[0]) || moves(s, w->u[1]);
    for (int i = 0; i < s->n && !elsewhere; i++)
        elsewhere = fabs(w->q[1][i] - w->q[0][i]) > SHUT * s->unit[i];
    return !elsewhere;
}

enum outcome step_by_singularity(const struct stretch *w, double t, double *y, int *there_is)
{
    struct advance a;
    *there_is = 0;
    if (!w->system->rows_on || w->drift != DRIFT_PROJECTED || !w->method->step)
        return OUTCOME_DONE;
    enum outcome outcome = begin_at(w, w->method, 0, t - w->t[0], &a);
    double *end = TAKE(a.s.arena, double, a.s.size);
    if (!outcome && a.s.arena->ran_out)
        outcome = OUTCOME_NO_MEMORY;
    if (!outcome) {
        write_row(w, 1, end);
        a.f.h = w->t[1] - w->t[0];
        *there_is = comes_near_singularity(&a.f, end);
    }
    end_advance(&a, OUTCOME_NOT_CLOSED, y);
    if (outcome || !*there_is)
        return outcome;
    if (stands(w)) { /* no velocity tells a branch */
        write_row(w, 0, y);
        return OUTCOME_DONE;
    }
    outcome = step_along_branch(w, 0, t, y);
    if (outcome && outcome != OUTCOME_INTERRUPTED && !w->count)
        outcome = step_along_branch(w, 1, t, y); /* from where the velocities may tell the branch better */
    *there_is = !outcome || outcome == OUTCOME_INTERRUPTED;
    return *there_is ? outcome : OUTCOME_DONE;
}
