/* Steps from rows of a record: for states between them. */
#include "interface/advance.h"

#include <math.h>
#include <string.h>

#include "methods/gauss.h"
#include "steps/kinks.h"
#include "steps/phase.h"
#include "steps/cut_step.h"
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
    a->run = (struct run){.method = method, .tolerance = w->tolerance};
    a->run.tolerance.unit = s->unit;
    a->f = (struct phase){.s = s, .run = &a->run, .t = w->t[end], .at.place = NAN};
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

enum outcome step_beside(const struct stretch *w, double t, double *y, int *beside)
{
    struct advance a;
    const double h = w->t[1] - w->t[0];
    enum outcome outcome = begin_at(w, w->method, 0, h, &a);
    *beside = 0;
    if (!outcome) {
        double *end = TAKE(a.s.arena, double, a.s.size);
        if (a.s.arena->ran_out) {
            outcome = OUTCOME_NO_MEMORY;
        } else {
            write_row(w, 1, end);
            a.f.h = h;
            *beside = lies_beside_singularity(&a.f, end, t);
            outcome = *beside ? come_beside_singularity(&a.f, end, t) : OUTCOME_DONE;
        }
    }
    end_advance(&a, outcome, y);
    return outcome;
}
