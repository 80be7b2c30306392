/* Hand-over between flight and contact: which closed contacts are held from now on (docs/events.md).
 *
 * Among the contacts that are closed and hardly move, the forces P solve
 *
 *     0 <= P,  0 <= z = W P + b,  P.z = 0,    b = N u_dot_free + dN/dt u,
 *
 * so that no gap accelerates inwards and none is pulled. Those that push are held, and those that neither push nor open, as
 * between bodies that move side by side: let go, rounding would open and close them without end. One that still bounces is held only
 * when its bounces are over within no time: with speed v after the impact, falling back at the acceleration a that it would
 * have if it alone were let go, it is in the air for 2 v / a, and with the restitution e all its bounces to come take
 * 2 v / (a (1 - e)), eq. 5.7 with kappa = e; or, where gaps of some size cannot be known, when they are no higher than that,
 * v^2 / (2 a).
 */
#include "hybrid/contact_transition.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "algebra/semidefinite.h"
#include "complementarity/complementarity.h"
#include "complementarity/friction.h"
#include "hybrid/decision.h"
#include "motion/projection.h"

/* share of its own compliance that is left of a contact which others carry */
static const double DEPENDENT = CCGEN_LIMIT(1e-9, 1e-4);

/* Solve for the contacts that take part, but without `except`: P[all]. */
static enum outcome solve(struct decision *d, int except, double *P)
{
    const int n = d->count, rough = d->all > n;
    double *W = d->part, *b = W + d->all * d->all, *mu = b + d->all, *x = mu + n;
    signed char *slide = d->slide + n;
    int m = 0;
    for (int i = 0; i < n; i++)
        m += d->in[i] && i != except;
    const int width = rough ? 2 * m : m;
    int k = 0;
    for (int i = 0; i < d->all; i++) {
        if (!d->in[i % n] || i % n == except)
            continue;
        int l = 0;
        for (int j = 0; j < d->all; j++)
            if (d->in[j % n] && j % n != except)
                W[k * width + l++] = d->W[i * d->all + j];
        if (rough && k < m) {
            mu[k] = d->mu[d->contact[i]];
            slide[k] = d->slide[i];
        }
        b[k++] = d->b[i];
    }
    memset(P, 0, d->all * sizeof *P);
    const int wrong = rough ? solve_friction(m, W, b, b + m, mu, slide, NULL, x, x + m) : solve_complementarity(m, W, b, x);
    if (wrong)
        return rough && wrong == 1 ? OUTCOME_JAMMED : OUTCOME_REPEATS;
    k = 0;
    for (int i = 0; i < d->all; i++)
        if (d->in[i % n] && i % n != except)
            P[i] = x[k++];
    return OUTCOME_DONE;
}

static double gap_acceleration(const struct decision *d, int i, const double *P)
{
    double z = d->b[i];
    for (int j = 0; j < d->all; j++)
        z += d->W[i * d->all + j] * P[j];
    return z;
}

static int pushes(const struct decision *d, int i)
{
    return d->in[i] && d->P[i] * d->W[i * d->all + i] > PRESSED * d->scale;
}

/* whether contact i is held */
static int stays(const struct decision *d, int i)
{
    return d->touches[i] || pushes(d, i);
}

/* Take out contacts that still bounce, until all that push have come to rest. */
static enum outcome take_out(const struct flight *f, struct decision *d, int resting)
{
    for (int i = 0; i <= d->count; i++) {
        if (interrupted(f->s->interruption, 0))
            return OUTCOME_INTERRUPTED;
        enum outcome outcome = solve(d, -1, d->P);
        if (outcome)
            return outcome;
        int bouncing = -1;
        for (int j = 0; j < d->count && bouncing < 0; j++) {
            const double speed = f->rates[d->contact[j]], e = f->s->restitution[d->contact[j]];
            if (!pushes(d, j) || speed <= slow(f, d->contact[j]) || resting == ALL_REST || resting == d->contact[j])
                continue;
            if ((outcome = solve(d, j, d->rest)))
                return outcome;
            const double fall = -gap_acceleration(d, j, d->rest) / d->enlarged;
            if (!(2.0 * speed <= REST_TIME * fmax(1.0, fabs(f->t)) * fall * (1.0 - e)) &&
                !(speed * speed <= 2.0 * fall * f->unresolved * f->s->extent[d->contact[j]]))
                bouncing = j;
        }
        if (bouncing < 0)
            return OUTCOME_DONE;
        d->in[bouncing] = 0;
    }
    return OUTCOME_DONE;
}

/* Whether the motion of row i (a gap, or beyond `count` a sliding) is fixed by what is held: the gaps of all that stay, and
 * the sliding of those that stick. `slide` is that of the contacts that stay, in their order. */
static int fixed(struct decision *d, int i, const signed char *slide)
{
    const int n = d->count, all = d->all;
    double *W = d->part, *r = W + all * all, *x = r + all, left = d->W[i * all + i];
    int *row = d->row, m = 0, k = 0;
    for (int a = 0; a < n; a++) {
        if (!stays(d, a))
            continue;
        row[m++] = a;
        if (slide[k++] == STICKS && n + a != i)
            row[m++] = n + a;
    }
    for (int a = 0; a < m; a++) {
        for (int b = 0; b < m; b++)
            W[a * m + b] = d->W[row[a] * all + row[b]];
        r[a] = d->W[row[a] * all + i];
    }
    solve_semidefinite(m, W, r, x, x + all);
    for (int a = 0; a < m; a++)
        left -= r[a] * x[a];
    return left <= DEPENDENT * d->W[i * all + i];
}

/* At which limit the friction of contact i is: 1 where it is against forward sliding, -1 backward, 0 within the limits */
static int at_limit(const struct decision *d, int i)
{
    const double limit = d->mu[d->contact[i]] * d->P[i], friction = d->P[d->count + i];
    const double edge = (d->given[i] ? 1e-6 : 1e-12) * limit;
    return friction <= -limit + edge ? 1 : friction >= limit - edge ? -1 : 0;
}

/* How a contact that pushes moves along its ground: it sticks where its sliding does not accelerate, else it slides against
 * friction at its limit. Where events follow each other without time, one that gives and yet does not accelerate, or has just
 * given or stopped, stays at its limit: what it slides is rounding, and would send it back and forth. */
static signed char slide_of(const struct decision *d, int i)
{
    if (d->all == d->count || d->mu[d->contact[i]] == 0.0)
        return SMOOTH;
    if (d->touches[i])
        return TOUCHES;
    if (d->slide[i])
        return d->slide[i];
    const int how = d->crowded && d->contact[i] == d->loss.contact ? d->loss.how : PULLS;
    const int sign = how == GIVES_FORWARD ? 1 : how == GIVES_BACKWARD ? -1 : at_limit(d, i);
    const int moves = sign && fabs(gap_acceleration(d, d->count + i, d->P)) > PRESSED * d->scale;
    if (d->crowded && sign && ((!moves && d->given[i]) || how == STOPS || how == GIVES_FORWARD || how == GIVES_BACKWARD))
        return (signed char)(sign * LIMIT);
    return moves || (sign && d->given[i]) ? sign : STICKS;
}

/* Hold the contacts that stay. With `limits`, friction that is at its limit stays there although the contact does not move,
 * because others that stick do not let it. */
static void hold_pushing(struct flight *f, struct decision *d, int limits)
{
    signed char *slide = d->slide + d->count;
    int count = 0;
    for (int i = 0; i < d->count; i++)
        if (stays(d, i)) {
            slide[count] = slide_of(d, i);
            f->s->holding->least[count] = d->touches[i] ? 2.0 * PRESSED * d->scale / d->W[i * d->all + i] : 0.0;
            f->set[count++] = d->contact[i];
        }
    for (int i = 0, k = 0; limits && i < d->count; i++) {
        if (!stays(d, i))
            continue;
        if (slide[k] != TOUCHES && (slide[k] == STICKS || d->given[i]) && at_limit(d, i) && fixed(d, d->count + i, slide))
            slide[k] = (signed char)(at_limit(d, i) * LIMIT);
        k++;
    }
    hold_contacts(f->s->holding, count, f->set, slide);
    for (int i = 0, k = 0, row = count; i < d->count; i++)
        if (stays(d, i) && slide[k++] == STICKS)
            f->s->holding->weight[row++] = sqrt(d->mu[d->contact[i]] * d->P[i] / d->scale);
}

/* Hold those too that neither push nor open; what has just stirred is not asked again. */
static void keep_touching(struct flight *f, struct decision *d, struct loss loss, int limits)
{
    for (int i = 0; i < d->count; i++) {
        const int c = d->contact[i];
        if (stays(d, i) || !d->in[i] || c == loss.contact || fabs(f->rates[c]) > slow(f, c) ||
            fabs(gap_acceleration(d, i, d->P)) > PRESSED * d->scale || fixed(d, i, f->s->holding->slide))
            continue;
        d->touches[i] = 1;
        hold_pushing(f, d, limits);
    }
}

/* Hold the contacts that stay, and note which others they carry. Forces of least norm share the
 * friction of those that stick, beside each other or with the joints; if that is more than one of them can bear, they share
 * it as the solution has it. */
static enum outcome hold(struct flight *f, struct decision *d, struct loss loss)
{
    struct holding *h = f->s->holding;
    const int gives = loss.how == GIVES_FORWARD || loss.how == GIVES_BACKWARD;
    hold_pushing(f, d, gives);
    keep_touching(f, d, loss, gives);
    for (int i = 0; i < h->count; i++)
        h->closed[h->set[i]] = HELD;
    for (int i = 0; i < d->count && h->count; i++)
        if (!stays(d, i) && fixed(d, i, h->slide)) {
            h->closed[d->contact[i]] = CARRIED;
            h->carried++;
        }
    if (h->rows <= h->count)
        return OUTCOME_DONE;
    double *values = f->search;
    const enum outcome outcome = watch(f->s, f->t, f->y, f->dy, values);
    int over = 0;
    for (int w = h->count; w < watched(f->s); w++)
        over |= watcher(f->s, w).how != STOPS && values[w] < 0.0;
    if (over)
        hold_pushing(f, d, 1);
    return outcome;
}

/* Whether a contact that slides could as well leave as stay: friction that grows faster than what it resists (Painleve). */
static int undetermined(const struct decision *d)
{
    for (int i = 0; d->all > d->count && i < d->count; i++) {
        const double *row = d->W + i * d->all, own = row[i] - d->slide[i] * d->mu[d->contact[i]] * row[d->count + i];
        if (d->in[i] && d->slide[i] && own < 0.0 && d->b[i] > PRESSED * d->scale)
            return 1;
    }
    return 0;
}

/* Bring the gaps of what is held to rest, and the sliding of what was asked whether it slides: that is rounding, and may be
 * against the direction in which it will slide. Other closed contacts that this drives into their grounds come to rest with
 * them: they would strike and undo it. */
static enum outcome rest(struct flight *f, struct decision *d, int resting)
{
    struct holding *h = f->s->holding;
    signed char *slide = d->slide + d->count;
    const int count = h->count, rows = h->rows;
    memcpy(slide, h->slide, count);
    memcpy(d->rest, h->weight, rows * sizeof *d->rest);
    for (int i = 0, k = 0; f->s->friction && i < d->count; i++)
        if (stays(d, i)) {
            h->slide[k] = d->slide[i] || d->touches[i] || d->mu[d->contact[i]] == 0.0 ? slide[k] : STICKS;
            k++;
        }
    hold_contacts(h, count, h->set, h->slide);
    enum outcome outcome = project_velocity(f->s, f->y, f->y + f->s->n);
    f->s->model->gap_rates(f->s->k, f->y, f->y + f->s->n, f->rates);
    for (int i = 0; resting == ALL_REST && i < d->count; i++)
        if (!stays(d, i) && f->rates[d->contact[i]] < 0.0) {
            h->slide[h->count] = SMOOTH;
            h->set[h->count++] = d->contact[i];
        }
    if (!outcome && h->count > count) {
        hold_contacts(h, h->count, h->set, h->slide);
        outcome = project_velocity(f->s, f->y, f->y + f->s->n);
    }
    hold_contacts(h, count, h->set, slide);
    memcpy(h->weight, d->rest, rows * sizeof *d->rest);
    return outcome;
}

/* Which contacts are held from now on, the state being left where it is. */
static enum outcome choose(struct flight *f, struct decision *d, struct loss loss, int resting)
{
    d->crowded = resting == ALL_REST;
    d->loss = loss;
    enum outcome outcome = gather(f, d);
    if (!outcome && undetermined(d))
        return OUTCOME_JAMMED;
    if (!outcome && d->count)
        outcome = take_out(f, d, resting);
    return outcome || !d->count ? outcome : hold(f, d, d->loss);
}

static enum outcome decide(struct flight *f, struct decision *d, struct loss loss, int resting)
{
    enum outcome outcome = choose(f, d, loss, resting);
    if (outcome || !f->s->holding->count)
        return outcome;
    outcome = project_position(f->s, f->y);
    return outcome ? outcome : rest(f, d, resting);
}

/* How every contact is held, for the record: 0 apart, 1 slides backward, 2 smooth, 3 forward,
 * 4 sticks, 5 carried, 6 and 7 at the limit of friction, 8 touches */
static void present(const struct holding *h, int contacts, signed char *out)
{
    for (int c = 0; c < contacts; c++)
        out[c] = h->closed[c] == CARRIED ? 5 : 0;
    for (int i = 0; i < h->count; i++)
        out[h->set[i]] = h->slide[i] == LIMIT ? 6 : h->slide[i] == -LIMIT ? 7 : h->slide[i] == TOUCHES ? 8 : 2 + h->slide[i];
}

static void let_go(struct holding *h, size_t contacts)
{
    memset(h->closed, APART, contacts);
    h->carried = 0;
    h->window = 0.0;
    hold_contacts(h, 0, NULL, NULL);
}

enum outcome settle(struct flight *f, struct loss loss, int resting)
{
    struct holding *h = f->s->holding;
    struct run *run = f->run;
    const size_t c = f->s->model->contacts;
    struct decision d;
    signed char *how = malloc(c);
    enum outcome outcome = OUTCOME_NO_MEMORY;
    if (!make_decision(&d, f->s) && how) {
        outcome = find_vanishing(f, loss, &d.vanishing, d.W);
        let_go(h, c);
        outcome = outcome ? outcome : decide(f, &d, loss, resting);
        if (!h->count)
            memset(h->peak, 0, c * sizeof *h->peak);
        present(h, (int)c, how);
        if (!outcome && append_hold(&run->holds, f->t, (int)c, how, h))
            outcome = OUTCOME_NO_MEMORY;
        if (!outcome && keep(f))
            outcome = OUTCOME_NO_MEMORY;
        if (outcome == OUTCOME_JAMMED)
            run->contact = d.count ? d.contact[0] : -1;
    }
    free(how);
    free_decision(&d);
    return outcome;
}

enum outcome would_hold(struct flight *f, int *strikes)
{
    const struct system *s = f->s;
    const struct loss none = {-1, PULLS};
    struct decision d;
    enum outcome outcome = OUTCOME_NO_MEMORY;
    *strikes = -1;
    if (!make_decision(&d, f->s)) {
        let_go(s->holding, s->model->contacts);
        outcome = choose(f, &d, none, NONE_RESTS);
        for (int c = 0, i = 0; c < s->model->contacts && !outcome; c++) {
            const int asked = i < d.count && d.contact[i] == c;
            i += asked;
            if (!asked && f->gaps[c] <= SHUT * s->extent[c] && f->rates[c] < 0.0 &&
                (*strikes < 0 || f->rates[c] < f->rates[*strikes]))
                *strikes = c;
        }
    }
    free_decision(&d);
    return outcome;
}
