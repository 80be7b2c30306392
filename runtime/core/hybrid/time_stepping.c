/* Time stepping in spans, with steps that are short against what they miss; see time_stepping.h, and contact_step.c for the step. */
#include "hybrid/time_stepping.h"

#include <math.h>

#include "base/tolerances.h"
#include "hybrid/contact_step.h"
#include "hybrid/contact_transition.h"
#include "model/scales.h"
#include "steps/kinks.h"

enum {
    PER_SPAN = 10, /* steps that a span has at least */
    FINER = 64     /* how much shorter one may become */
};

/* Spans last a ten-thousandth of a characteristic time, or of half a turn at the present rate where that is less: long against what crowds
 * and short against the motion. They last three times the last where that has not helped, up to a third of it. */
static const double HALF_TURN = 3.14159265358979323846;
static const double SPAN = 1e-4, LONGER = 3.0, LONGEST = 0.3, SOON = 10.0;

/* A span ends in steps that get shorter, to a quarter of each other, until bounces are over in one: a contact that sticks in the middle of a step slides at its end
 * by what its ground turns in half of it, and to events that is sliding, with a direction of its own and friction at its limit. Friction that holds a contact stops
 * in a quarter of the time what the step before has left. */
static const double LEFT = 0.25;

/* How far two ends of a step are apart, in units of the coordinates */
static double apart(const struct system *s, const double *a, const double *b)
{
    double found = 0.0;
    for (int i = 0; i < s->n; i++)
        found = fmax(found, fabs(a[i] - b[i]) / s->unit[i]);
    return found;
}

/* A step to f->y1 that does not miss more than STEPPED, or is as short as steps get: two halves, and what they differ by from the whole.
 * *next is the step to try next. */
static enum outcome controlled_step(struct phase *f, struct step_room *r, double longest, double *h, double *next,
                                    double *miss)
{
    const double least = longest / FINER, t = f->t;
    const long rejected = f->run->rejected;
    for (;; *h *= 0.5) {
        enum outcome outcome = step_once(f, r, t, *h, f->y, r->whole);
        outcome = outcome ? outcome : step_once(f, r, t, 0.5 * *h, f->y, r->half);
        const double jump = r->jump;
        outcome = outcome ? outcome : step_once(f, r, t + 0.5 * *h, 0.5 * *h, r->half, f->y1);
        r->jump += jump;
        if (outcome == OUTCOME_INTERRUPTED)
            f->run->rejected = rejected;
        if (outcome == OUTCOME_NO_MEMORY || outcome == OUTCOME_INTERRUPTED)
            return outcome;
        const int last = *h <= least;
        if (outcome && last)
            return outcome;
        *miss = outcome ? INFINITY : apart(f->s, r->whole, f->y1);
        if (outcome || (*miss > STEPPED && !last)) {
            f->run->rejected++;
            continue;
        }
        *next = fmin(longest, *miss < 0.25 * STEPPED ? 2.0 * *h : *h);
        return OUTCOME_DONE;
    }
}

/* Go on by h to f->y1. */
static enum outcome commit(struct phase *f, double t, double h, double miss, double jump)
{
    double *swap = f->y;
    f->y = f->y1;
    f->y1 = swap;
    f->t = t;
    f->run->steps++;
    if (record_state(f))
        return OUTCOME_NO_MEMORY;
    if (note_stepping(&f->run->stepping, t, h, miss, jump, f->run->record.count))
        return OUTCOME_NO_MEMORY;
    return follow_sides(f);
}

/* Go on from the present record: the stepping begins, or goes on in a run that has begun again. */
static enum outcome open_record(struct phase *f)
{
    struct run *run = f->run;
    return record_state(f) || open_stepping(&run->stepping, f->t, run->record.count) ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
}

/* The step to try next, so far from where the span ends */
static double towards_end(const struct phase *f, double left, double h)
{
    const double settled = REST_TIME * fmax(f->s->time, fabs(f->t));
    return !f->s->friction || left <= settled ? h : fmin(h, (1.0 - LEFT) * left);
}

int contacts_have_none(enum outcome outcome)
{
    return outcome == OUTCOME_JAMMED || outcome == OUTCOME_REPEATS || outcome == OUTCOME_NOT_CLOSED ||
           outcome == OUTCOME_NO_CONVERGENCE || outcome == OUTCOME_NOT_KEPT;
}

static enum outcome go_through(struct span *span, struct phase *f, struct step_room *r, double end, double longest)
{
    const int fixed = !span->under_way; /* no span: the whole run goes so */
    enum outcome outcome = open_record(f);
    f->at.under_way = 1; /* what is done stays done where it is interrupted */
    while (!outcome && f->t < end) {
        f->run->interruption.t = f->t;
        if (ask(&f->run->interruption))
            return OUTCOME_INTERRUPTED;
        if (f->run->steps + f->run->rejected - f->run->taken_before >= f->run->step_budget)
            return OUTCOME_BUDGET;
        const double stop = fmin(next_stop(f->run, f->t), end);
        const double near = fixed ? longest : towards_end(f, span->ends - f->t, span->step);
        double h = near, next = h, miss = 0.0;
        const int last = f->t + 1.01 * h >= stop;
        h = last ? stop - f->t : h;
        const double whole = h;
        outcome = fixed ? step_once(f, r, f->t, h, f->y, f->y1) : controlled_step(f, r, longest, &h, &next, &miss);
        if (!fixed && f->t > span->begins && contacts_have_none(outcome)) {
            span->ends = f->t;                  /* events may go on from wherever steps have come to, */
            span->length = f->t - span->begins; /* and steps, if need be, no coarser than these */
            return OUTCOME_DONE;
        }
        if (outcome)
            break;
        if (turned_far(f->s, f->y1))
            return OUTCOME_TURNED_FAR;
        span->step = last && h == whole ? fmax(next, span->step) : next;
        outcome = commit(f, last && h == whole ? stop : f->t + h, h, miss, r->jump);
    }
    return outcome;
}

static enum outcome with_room(struct span *span, struct phase *f, double end, double longest)
{
    const struct mark mark = f->s->arena->top;
    struct step_room r;
    enum outcome outcome = take_step_room(f->s, &r) ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    if (!outcome) {
        if (!(span->scale > 0.0))
            span->scale = heaviest(f->s, f->y);
        r.scale = span->scale;
        outcome = r.scale < 0.0 ? OUTCOME_NO_MEMORY : go_through(span, f, &r, end, longest);
    }
    give_back(f->s->arena, mark);
    return outcome;
}

enum outcome begin_span(struct span *span, struct phase *f)
{
    const double fast = fastest(f->s, f->y + f->s->n),
                 time = f->s->time * fast > HALF_TURN ? HALF_TURN / fast : f->s->time;
    const int again = span->length > 0.0 && f->t <= span->ends + SOON * span->length;
    span->length = again ? fmin(LONGER * span->length, LONGEST * time) : SPAN * time;
    span->begins = f->t;
    span->ends = f->t + span->length;
    span->step = span->length / PER_SPAN;
    span->scale = 0.0;
    span->under_way = 1;
    return release_contacts(f);
}

enum outcome step_through_span(struct span *span, struct phase *f)
{
    const enum outcome outcome = with_room(span, f, fmin(span->ends, f->run->until), span->length / PER_SPAN);
    span->under_way = outcome == OUTCOME_INTERRUPTED || f->t < span->ends;
    return outcome;
}

enum outcome step_to_end(struct span *span, struct phase *f)
{
    return with_room(span, f, f->run->until, f->run->fixed_step);
}
