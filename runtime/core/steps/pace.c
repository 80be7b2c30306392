/* Whether a run gets on; see pace.h. */
#include "steps/pace.h"

#include <math.h>

#include "base/tolerances.h"
#include "constraints/nullspace.h"

enum { TICK = 64 /* short steps between two questions whether to go on */ };

double window_of(const struct phase *f)
{
    const double duration = f->run->duration;
    return fmin(0.1 * duration, fmax(1e-4 * duration, f->s->time));
}

/* Whether the run has taken more steps that get nowhere, and events, than a window may have */
static int exceeds_step_rate(const struct phase *f)
{
    struct run *run = f->run;
    const long spent = run->steps + run->rejected + run->events;
    if (f->t >= run->window + window_of(f)) {
        run->window = f->t;
        run->spent_before = spent;
    }
    const int exceeds = run->fixed_step == 0.0 && spent - run->spent_before > run->rate_budget;
    if (exceeds) { /* who goes on has another budget */
        run->window = f->t;
        run->spent_before = spent;
    }
    return exceeds;
}

void excuse_progress(struct phase *f, long spent)
{
    struct run *run = f->run;
    if (f->h * fastest(f->s, f->y + f->s->n) >= GETS_ON)
        run->spent_before += run->steps + run->rejected - spent;
}

int stalls(const struct phase *f)
{
    const struct ccgen_model *model = f->s->model;
    return f->h * fastest(f->s, f->y + f->s->n) < CRAWL &&
           (model->contacts || (f->s->rows_on && !f->at.bounded && rank_margin(f->s, f->y) < BRIDGED));
}

int is_crawling(const struct phase *f)
{
    return f->at.crawled >= f->run->rate_budget / 20;
}

int is_stuck(const struct phase *f)
{
    return f->run->fixed_step == 0.0 && !(f->s->model->drives && f->s->model->contacts) && is_crawling(f) &&
           f->t - f->at.crawls_since < STANDSTILL * f->s->time;
}

/* So many steps show a pace: more than twice what a window may have of those that get nowhere, which are told as such, or stepped over, before. */
static const long STRETCH = 500000;

/* The pace of the rest of a run would have to be so many times that of a stretch: what whirls or creeps for a while gets on faster by
 * less. */
static const double SPEED_UP = 1e3;

/* Whether all of the budget, at the pace of the last steps, would be next to nothing of what the run still has before it */
static int is_endless(struct phase *f)
{
    struct run *run = f->run;
    const long taken = run->steps + run->rejected;
    if (!run->paced || taken - run->paced_from < STRETCH)
        return 0;
    const double passed = f->t - run->paced_since;
    run->paced_from = taken;
    run->paced_since = f->t;
    return passed * SPEED_UP * ((double)run->step_budget / (double)STRETCH) < run->until - f->t;
}

enum outcome within_budget(struct phase *f)
{
    struct run *run = f->run;
    run->interruption.t = f->t;
    const int asked = run->pauses == BEHIND_A_STEP; /* where it paused before this step */
    if ((run->steps % TICK == 0 && !asked && ask(&run->interruption)) || interrupted(f->s->interruption, 0))
        return OUTCOME_INTERRUPTED;
    if (run->steps + run->rejected - run->taken_before >= run->step_budget)
        return OUTCOME_BUDGET;
    if (is_endless(f))
        return OUTCOME_ENDLESS;
    return exceeds_step_rate(f) ? OUTCOME_CROWDED : OUTCOME_DONE;
}
