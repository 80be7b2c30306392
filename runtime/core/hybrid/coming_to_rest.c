/* Of what is as slow as what may rest, not all can come to rest at once.
 *
 * Where drives move one contact against another rows depend on each other, and the projection leaves one out: a held contact goes on, or a loop opens, or a joint is driven
 * otherwise, which the next step would give back. And in a crowd of events, what is brought to rest may drive another in, which strikes
 * and undoes it.
 * One of them then goes on as it was: where one still slides, the one that slid fastest; else the one that opened fastest, which is in the air; else the one that slid fastest.
 */
#include "hybrid/coming_to_rest.h"

#include <math.h>
#include <string.h>

#include "base/tolerances.h"
#include "constraints/nullspace.h"
#include "constraints/rows.h"
#include "hybrid/activation.h"
#include "model/contacts.h"

int note_before_rest(struct phase *f, struct before_rest *before)
{
    struct system *s = f->s;
    const size_t contacts = s->model->contacts;
    *before = (struct before_rest){.y = TAKE(s->arena, double, s->size),
                                   .rates = TAKE(s->arena, double, contacts),
                                   .slips = TAKE_ZEROS(s->arena, double, contacts),
                                   .rest_speed = f->run->rest_speed,
                                   .opens = TAKE_ZEROS(s->arena, char, contacts),
                                   .moves = TAKE_ZEROS(s->arena, char, contacts)};
    if (s->arena->ran_out)
        return 1;
    memcpy(before->y, f->y, (size_t)s->size * sizeof *f->y);
    contact_rates(s, f->y, f->y + s->n, before->rates);
    if (s->friction)
        s->model->slips(s->k, f->y, f->y + s->n, before->slips);
    return 0;
}

/* What is slower, for what is so long, is at rest. */
static double still(const struct system *s, double extent)
{
    return STILL * extent / s->time;
}

/* Of those that are to be at rest along their grounds, the one with the largest of slips[contacts] in size, or -1 where none of them slides. */
static int slides_fastest(const struct phase *f, const struct decision *d, const struct before_rest *before,
                          const char *goes_on, const double *slips)
{
    const struct system *s = f->s;
    double fastest = still(s, s->length);
    int found = -1;
    for (int i = 0; s->friction && i < d->count; i++) {
        const int c = d->contact[i];
        if (stays(d, i) && !goes_on[i] && !before->moves[c] && fabs(slips[c]) > fastest) {
            fastest = fabs(slips[c]);
            found = c;
        }
    }
    return found;
}

/* Whether a held contact moves, or whether loops and drives do not go as they are to; missed[rows] is room. */
static int asks_too_much(const struct phase *f, const struct before_rest *before, double *missed)
{
    const struct system *s = f->s;
    const struct active_set *h = s->active;
    const double *q = f->y, *u = f->y + s->n;
    int too_much = 0;
    contact_rates(s, q, u, f->rates);
    for (int i = 0; i < h->count; i++)
        too_much |= fabs(f->rates[h->set[i]]) > still(s, s->extent[h->set[i]]);
    s->model->closure_rate(s->k, q, u, missed);
    for (int i = 0; i < s->model->rows; i++)
        too_much |= fabs(missed[i]) > still(s, s->length);
    for (int k = 0; k < s->model->drives; k++) {
        const double driven = driven_by(s->model, k, u) - driven_by(s->model, k, before->y + s->n);
        too_much |= fabs(driven) > still(s, s->lengths[s->model->driven[2 * k]] ? s->length : 1.0);
    }
    return too_much;
}

int another_opens(const struct phase *f, const struct before_rest *before)
{
    struct system *s = f->s;
    if (!s->model->drives && rank_margin(s, f->y) >= BRIDGED)
        return 0;
    for (int i = 0; i < s->active->count; i++)
        if (before->rates[s->active->set[i]] > still(s, s->extent[s->active->set[i]]))
            return 1;
    return 0;
}

/* Whether a candidate that is not held is driven in by those that are */
static int drives_in(struct phase *f, const struct decision *d)
{
    const struct system *s = f->s;
    contact_rates(s, f->y, f->y + s->n, f->rates);
    for (int i = 0; i < d->count; i++)
        if (!stays(d, i) && f->rates[d->contact[i]] < -still(s, s->extent[d->contact[i]]))
            return 1;
    return 0;
}

/* The held contact that opened fastest before, or -1 */
static int opened_fastest(const struct phase *f, const struct before_rest *before)
{
    const struct system *s = f->s;
    const struct active_set *h = s->active;
    double fastest = still(s, 1.0);
    int found = -1;
    for (int i = 0; i < h->count; i++) {
        const int c = h->set[i];
        if (before->rates[c] > fastest * s->extent[c]) {
            fastest = before->rates[c] / s->extent[c];
            found = c;
        }
    }
    return found;
}

enum outcome ask_for_less(struct phase *f, const struct decision *d, const struct before_rest *before,
                          const char *goes_on, int *again)
{
    struct system *s = f->s;
    const struct mark mark = s->arena->top;
    double *missed = TAKE(s->arena, double, s->model->rows), *slips = TAKE_ZEROS(s->arena, double, s->model->contacts);
    const enum outcome outcome = s->arena->ran_out ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    int opens = -1, slides = -1;
    const int crowds = d->events_crowd || f->at.slow > 0.0;
    if (!outcome && s->active->count && (s->model->drives || crowds)) {
        if (s->friction)
            s->model->slips(s->k, f->y, f->y + s->n, slips);
        const int one_slides = slides_fastest(f, d, before, goes_on, slips) >= 0;
        if (one_slides || (s->model->drives && asks_too_much(f, before, missed)) || (crowds && drives_in(f, d))) {
            slides = one_slides ? slides_fastest(f, d, before, goes_on, before->slips) : -1;
            opens = slides < 0 ? opened_fastest(f, before) : -1;
            slides = slides < 0 && opens < 0 ? slides_fastest(f, d, before, goes_on, before->slips) : slides;
        }
    }
    *again = opens >= 0 || slides >= 0;
    if (opens >= 0)
        before->opens[opens] = 1;
    if (slides >= 0)
        before->moves[slides] = 1;
    if (*again) {
        memcpy(f->y, before->y, (size_t)s->size * sizeof *f->y);
        f->run->rest_speed = before->rest_speed;
    }
    give_back(s->arena, mark);
    return outcome;
}
