/* Impacts: which contacts strike, with how much of their restitution, and what they take; see striking.h. */
#include "hybrid/striking.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "base/tolerances.h"
#include "constraints/branch.h"
#include "constraints/nullspace.h"
#include "hybrid/immovable.h"
#include "impact/impact.h"
#include "model/contacts.h"

enum { HALVINGS = 30 /* of a part of restitution: to a billionth */ };

/* What an impact of the contacts f->set is about */
struct blow {
    int count;
    double *e;             /* [contacts] restitution */
    double *less;          /* [contacts] restitution that was tried in its place */
    double *P;             /* [2 contacts] impulses, normal ones and then those of friction */
    double *rates;         /* [contacts] scratch */
    double *du, *momentum; /* [n] scratch */
    double taken;          /* J: what the contacts take */
    int seen;    /* whether one approaches that is too fast to lose its restitution for many impacts at one instant */
    int plastic; /* whether one with restitution has none for that */
};

/* 0, or 1 when memory runs out */
static int take_blow(const struct system *s, struct blow *b)
{
    const size_t contacts = s->model->contacts;
    b->e = TAKE(s->arena, double, contacts);
    b->less = TAKE(s->arena, double, contacts);
    b->P = TAKE(s->arena, double, 2 * contacts);
    b->rates = TAKE(s->arena, double, contacts);
    b->du = TAKE(s->arena, double, s->n);
    b->momentum = TAKE(s->arena, double, s->n);
    return s->arena->ran_out;
}

/* The impact with the restitution of all contacts times `share`, and the energy that they take by that: b->taken */
static enum outcome strike_with(struct phase *f, struct blow *b, double share)
{
    double *u_plus = f->y1 + f->s->n;
    for (int i = 0; i < b->count; i++)
        b->less[i] = share * b->e[i];
    const enum outcome outcome = impact(f->s, f->y, f->y + f->s->n, b->count, f->set, b->less, u_plus, b->P);
    b->taken = contacts_take(f->s, f->y, b->count, f->set, b->P, f->rates, f->y + f->s->n, u_plus, b->rates);
    return outcome;
}

/* The energy (J) that the mechanism loses in the impact to u_plus: driven joints, which do not change their speeds, do work in it too. */
static double loss_of(const struct phase *f, const struct blow *b, const double *u_plus)
{
    return f->s->model->drives ? jump_loss(f->s, f->y, f->y + f->s->n, u_plus, b->du, b->momentum) : b->taken;
}

/* The impact with the restitution that contacts have, or where that would gain energy, or the law has no impulses for it, as where a rod would have to
 * spring back along a ground that wedges it, the largest part of it that has some and gains nothing (docs/events.md, "Striking"): by bisection, since
 * without any it never gains; where contacts differ in restitution it need not grow with the part, and a part is found that does not gain. Only one in
 * which contacts give no energy is taken: with a tolerance there, thousands of them add up. *share is that part. */
static enum outcome strike_together(struct phase *f, struct blow *b, double *share)
{
    enum outcome outcome = strike_with(f, b, *share = 1.0);
    if ((outcome != OUTCOME_GAINED && outcome != OUTCOME_JAMMED) || f->run->on_gain == GAIN_STOPS)
        return outcome;
    double above = 1.0, tried = 0.0;
    *share = 0.0;
    outcome = strike_with(f, b, tried);
    if (outcome || b->taken < 0.0)
        return outcome ? outcome : OUTCOME_GAINED;
    for (int i = 0; i < HALVINGS; i++) {
        tried = 0.5 * (*share + above);
        *(strike_with(f, b, tried) || b->taken < 0.0 ? &above : share) = tried;
    }
    return tried == *share ? OUTCOME_DONE : strike_with(f, b, *share);
}

/* The contacts f->set that take part in an impact of those that are closed, and of `trigger`, if that is not -1, in the first; in the `last` all, without
 * restitution. *approaching is whether there is one. */
static enum outcome gather_striking(struct phase *f, int trigger, int last, struct blow *b, int *approaching)
{
    const struct ccgen_model *m = f->s->model;
    *approaching = b->count = b->seen = b->plastic = 0;
    contact_gaps(f->s, f->y, f->gaps);
    contact_rates(f->s, f->y, f->y + f->s->n, f->rates);
    for (int c = 0; c < m->contacts; c++) {
        const double still = rest_velocity(f, c);
        if ((f->gaps[c] <= gap_tolerance(f, c) || c == trigger) && (last || f->rates[c] <= still))
            f->set[b->count++] = c;
    }
    const enum outcome outcome = leave_out_immovable(f, f->y, &b->count, f->set);
    for (int i = 0; i < b->count && !outcome; i++) {
        const int c = f->set[i],
                  rests = f->at.slow > 0.0 && may_rest(f, c, f->rates[c]) && fabs(f->rates[c]) <= rest_velocity(f, c);
        const int bounces = f->s->restitution[c] > 0.0 && f->rates[c] < -rest_velocity(f, c);
        b->e[i] = last || rests ? 0.0 : f->s->restitution[c];
        b->seen |= bounces && !may_rest(f, c, f->rates[c]);
        b->plastic |= last && bounces;
        *approaching |= f->rates[c] < -rest_velocity(f, c) || (c == trigger && f->rates[c] < 0.0);
    }
    return outcome;
}

/* What the gap of a contact is known to (m): half the last digits of the coordinates. row[n], push[contacts] are scratch, push being zeros. */
static double digits_of(const struct phase *f, int contact, double *row, double *push)
{
    const struct system *s = f->s;
    double sum = 0.0;
    push[contact] = lever_of(s, contact);
    s->model->contact_impulse(s->k, f->y, push, row);
    push[contact] = 0.0;
    for (int i = 0; i < s->n; i++)
        sum += fabs(row[i] * f->y[i]);
    return 0.5 * DBL_EPSILON * sum;
}

/* Whether nothing approaches that places could show. As its gap accelerates in the present motion, it has fallen from no height, and would go no further, than
 * the gap is known to: so do bounces lower than the last digits, and gaps that close without speed, as that of an edge when a wheel comes to it along
 * another. Bounces do not get lower either where they lose less of their height than that: what falls further by rounding comes back as fast. Beside a singular configuration
 * accelerations grow as the inverse square of the distance sigma from it, and last no longer: those times sigma^2 count. */
static enum outcome approaches_unseen(struct phase *f, const struct blow *b, int *unseen)
{
    struct system *s = f->s;
    const size_t contacts = s->model->contacts;
    const struct mark mark = s->arena->top;
    double *row = TAKE(s->arena, double, s->n), *push = TAKE_ZEROS(s->arena, double, contacts);
    double *rates = TAKE(s->arena, double, contacts), *bias = TAKE(s->arena, double, contacts);
    enum outcome outcome = s->arena->ran_out ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    *unseen = 1;
    for (int i = 0; i < b->count && *unseen; i++)
        *unseen = f->rates[f->set[i]] >= -SEEN * s->extent[f->set[i]] / s->time;
    if (outcome || !*unseen)
        goto end;
    outcome = evaluate_derivative(f);
    if (outcome) { /* as where friction jams: then it is not known */
        *unseen = 0;
        outcome = outcome == OUTCOME_INTERRUPTED || outcome == OUTCOME_NO_MEMORY ? outcome : OUTCOME_DONE;
        goto end;
    }
    if (s->branch && follows_at(s, f->y)) /* as it was evaluated */
        read_state_on_branch(s, f->y, f->y + s->n);
    contact_rates(s, f->y, f->dy + s->n, rates);
    contact_bias(s, f->y, f->y + s->n, bias);
    const double sigma = s->rows_on ? fmin(1.0, rank_margin(s, f->y)) : 1.0;
    for (int i = 0; i < b->count && *unseen; i++) {
        const int c = f->set[i];
        const double speed = fmin(f->rates[c], 0.0), e = s->restitution[c], a = rates[c] + bias[c];
        const double lost = a < 0.0 && e < 1.0 ? 1.0 - e * e : 1.0;
        *unseen = lost * speed * speed <= 2.0 * sigma * sigma * fabs(a) * digits_of(f, c, row, push);
    }
end:
    give_back(s->arena, mark);
    return outcome;
}

static enum outcome resolve_with(struct phase *f, int trigger, struct blow *b)
{
    struct run *run = f->run;
    const int n = f->s->n;
    for (int repeat = 0;; repeat++) {
        if (interrupted(f->s->interruption, 0))
            return OUTCOME_INTERRUPTED;
        int approaching;
        enum outcome outcome = gather_striking(f, repeat ? -1 : trigger, repeat == (int)REPEATS, b, &approaching);
        if (outcome || !approaching)
            return outcome;
        if (repeat > (int)REPEATS || (repeat == (int)REPEATS && b->seen)) {
            run->contact = f->set[0];
            return OUTCOME_REPEATS;
        }
        int unseen = 0;
        if (!repeat && (outcome = approaches_unseen(f, b, &unseen)))
            return outcome;
        for (int i = 0; i < b->count && unseen; i++)
            b->e[i] = 0.0;
        activate(f->s->active, 0, NULL, NULL); /* what was held may leave now */
        const double *u_plus = f->y1 + n;
        double share;
        outcome = strike_together(f, b, &share);
        share = b->plastic ? 0.0 : share;
        if (outcome) {
            run->contact = f->set[0];
            return outcome;
        }
        if (!memcmp(f->y + n, u_plus, n * sizeof *u_plus)) /* what approached did so by rounding: nothing has struck */
            continue;
        for (int i = 0; i < b->count; i++) {
            const int c = f->set[i], strikes = f->rates[c] < 0.0;
            f->met[c] += strikes;
            f->tight[c] += strikes; /* without time, whatever its gap */
            if (strikes && f->rates[c] >= -rest_velocity(f, c))
                note_rest(f, c, f->rates[c]);
        }
        if (record_state(f) || append_impact(&run->impacts, f->t, f->y + n, u_plus, n, b->count, f->set, b->P,
                                             loss_of(f, b, u_plus), share, run->record.count))
            return OUTCOME_NO_MEMORY;
        memcpy(f->y + n, u_plus, n * sizeof *u_plus);
        if (record_state(f))
            return OUTCOME_NO_MEMORY;
    }
}

enum outcome resolve_impacts(struct phase *f, int trigger)
{
    const struct mark mark = f->s->arena->top;
    struct blow blow;
    const enum outcome outcome = take_blow(f->s, &blow) ? OUTCOME_NO_MEMORY : resolve_with(f, trigger, &blow);
    give_back(f->s->arena, mark);
    return outcome;
}
