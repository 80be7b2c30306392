/* States between the rows of a run where a singular configuration lies between them; see look.h. */
#include "steps/look.h"

#include <math.h>
#include <string.h>

#include "base/tolerances.h"
#include "constraints/nullspace.h"
#include "methods/gauss.h"
#include "motion/derivative.h"
#include "steps/cut_step.h"
#include "steps/singular_step.h"
#include "steps/step_control.h"

/* How near to dependence rows are at time t on the cubic to end[2n] */
static double margin_at(struct phase *f, const double *end, double t)
{
    const struct mark mark = f->s->arena->top;
    double *q = TAKE(f->s->arena, double, f->s->n);
    double margin = INFINITY, first;
    if (!f->s->arena->ran_out) {
        between_ends(f, f->h, end, (t - f->t) / f->h, q);
        margin = margin_below(f, row_rank(f->s, f->y, &first), q);
    }
    give_back(f->s->arena, mark);
    return margin;
}

int passes_singularity(struct phase *f, const double *end)
{
    double part;
    if (!f->s->model->rows || !projects(f) || active_count(f->s) || f->s->model->switches ||
        (f->run->method != &gauss && !f->passing) || !nearest_part(f, end, 1.0, &part))
        return 0;
    f->at.place = f->t + part * f->h;
    return 1;
}

int lies_beside_singularity(struct phase *f, const double *end, double t)
{
    return margin_at(f, end, t) < near_dependence(f);
}

enum outcome come_clear_of_singularity(struct phase *f, double t)
{
    const double place = f->at.place;
    f->at.passage = BEFORE;
    const enum outcome outcome = advance_to(f, t);
    f->at.place = place;
    return outcome;
}

/* Go on to `until`, which lies clear of the configuration. */
static enum outcome begin_before(struct phase *f, double until)
{
    enum outcome outcome = come_clear_of_singularity(f, until);
    outcome = outcome ? outcome : system_derivative(f->s, until, f->y1, f->dy);
    if (outcome)
        return outcome;
    f->t = until;
    f->at.energy_known = 0;
    memcpy(f->y, f->y1, (size_t)f->s->size * sizeof *f->y);
    return OUTCOME_DONE;
}

enum outcome come_beside_singularity(struct phase *f, double t)
{
    const double limit = f->t + f->h;
    for (int tries = 0;; tries++) {
        int ends;
        const double way = t - f->t;
        if (!can_be_cut(f, way)) /* it begins beside the place */
            return OUTCOME_NO_CONVERGENCE;
        f->h = way;
        enum outcome outcome = cut_or_shorten(f, tries, limit, &ends);
        if (outcome || ends)
            return outcome;
        if (f->h == way)
            return OUTCOME_NO_CONVERGENCE;
        if ((outcome = begin_before(f, f->t + f->h)))
            return outcome;
    }
}

int comes_near_singularity(struct phase *f, const double *end)
{
    double part;
    const int rank = f->s->model->rows;
    if (!f->branch.chart || !projects(f))
        return 0;
    if (nearest_part(f, end, 1.0, &part))
        return 1;
    f->at.widest = fmax(closure_margin(f->s, f->y, rank), closure_margin(f->s, end, rank));
    return is_beside_place(f, f->y) || is_beside_place(f, end);
}

enum outcome look_along_branch(struct phase *f, double t)
{
    const enum outcome outcome = follow_branch(f);
    if (outcome)
        return outcome;
    return f->s->branch ? advance_to(f, t) : OUTCOME_NOT_CLOSED;
}
