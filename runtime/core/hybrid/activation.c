/* From the forces of a decision to the active set: which contacts stick, slide, stay at their limit, touch, and are carried. */
#include "hybrid/activation.h"

#include <math.h>

#include "base/tolerances.h"
#include "motion/switching.h"

double gap_acceleration(const struct decision *d, int i, const double *P)
{
    double z = d->b[i];
    for (int j = 0; j < d->all; j++)
        z += d->W[i * d->all + j] * P[j];
    return z;
}

int pushes(const struct decision *d, int i)
{
    return d->in[i] && d->P[i] * d->W[i * d->all + i] > PRESSED * d->scale;
}

int stays(const struct decision *d, int i)
{
    return d->touches[i] || pushes(d, i);
}

/* Whether the motion of row i (a gap, or beyond `count` a sliding) is fixed by what is held: the gaps of all that stay, and
 * the sliding of those that stick. `mode` is that of the contacts that stay, in their order. */
static int fixed(struct decision *d, int i, const signed char *mode)
{
    const int n = d->count, all = d->all;
    double *W = d->part.W, *r = d->part.b, *x = d->part.x, left = d->W[i * all + i];
    int *row = d->part.row, m = 0, k = 0;
    for (int a = 0; a < n; a++) {
        if (!stays(d, a))
            continue;
        row[m++] = a;
        if (mode[k++] == STICK && n + a != i)
            row[m++] = n + a;
    }
    for (int a = 0; a < m; a++) {
        for (int b = 0; b < m; b++)
            W[a * m + b] = d->W[row[a] * all + row[b]];
        r[a] = d->W[row[a] * all + i];
    }
    solve_semidefinite(m, W, r, x, &d->part.room);
    for (int a = 0; a < m; a++)
        left -= r[a] * x[a];
    return left <= IMPLIED_SHARE * d->W[i * all + i];
}

/* At which limit the friction of contact i is, within what rounding of the forces leaves: 1 where it is against forward sliding, -1 backward, 0 within
 * the limits. Where an event has shown that friction gives, what is rounding of an acceleration is none of the limit. */
static int at_limit(const struct decision *d, int i, int given)
{
    const double limit = d->mu[d->contact[i]] * d->P[i], friction = d->P[d->count + i];
    const double rounding = (given ? PRESSED : EDGE) * d->scale / d->W[i * (d->all + 1)];
    const double edge = fmax((given ? EDGE_GIVEN : EDGE) * limit, rounding);
    return friction <= -limit + edge ? 1 : friction >= limit - edge ? -1 : 0;
}

/* How a contact that pushes moves along its ground: it sticks where its sliding does not accelerate, else it slides against
 * friction at its limit. Where events follow each other without time, one that gives and yet does not accelerate, or has just
 * given or stopped, stays at its limit: what it slides is rounding, and would send it back and forth. */
static signed char mode_of(const struct decision *d, int i)
{
    if (d->all == d->count || d->mu[d->contact[i]] == 0.0)
        return FRICTIONLESS;
    if (d->touches[i])
        return GRAZING;
    if (d->mode[i])
        return d->mode[i];
    const int how = d->events_crowd && d->contact[i] == d->loss.contact ? d->loss.how : DETACHES;
    const signed char was = d->was[d->contact[i]];
    if (d->events_crowd && how == DETACHES && (was == AT_LIMIT_FORWARD || was == AT_LIMIT_BACKWARD) &&
        at_limit(d, i, 1) !=
            -against(was)) /* one that has been at its limit stays there, unless it comes to the other */
        return was;
    const int sign = how == SLIPS_FORWARD ? 1 : how == SLIPS_BACKWARD ? -1 : at_limit(d, i, d->given[i]);
    const int moves = sign && fabs(gap_acceleration(d, d->count + i, d->P)) > PRESSED * d->scale;
    if (d->events_crowd && sign &&
        ((!moves && d->given[i]) || how == SLIP_ENDS || how == SLIPS_FORWARD || how == SLIPS_BACKWARD))
        return (signed char)(sign * AT_LIMIT_FORWARD);
    return (signed char)(moves || (sign && d->given[i]) ? sign : STICK);
}

/* Hold the contacts that stay. With `limits`, friction that is at its limit stays there although the contact does not move,
 * because others that stick do not let it. */
static void activate_staying(struct phase *f, struct decision *d, int limits)
{
    signed char *mode = d->modes;
    int count = 0;
    for (int i = 0; i < d->count; i++)
        if (stays(d, i)) {
            mode[count] = mode_of(d, i);
            f->s->active->least[count] = d->touches[i] ? 2.0 * PRESSED * d->scale / d->W[i * d->all + i] : 0.0;
            f->set[count++] = d->contact[i];
        }
    for (int i = 0, k = 0; limits && i < d->count; i++) {
        if (!stays(d, i))
            continue;
        const int sign = at_limit(d, i, 1);
        if (mode[k] != GRAZING && (mode[k] == STICK || d->given[i]) && sign && fixed(d, d->count + i, mode))
            mode[k] = (signed char)(sign * AT_LIMIT_FORWARD);
        k++;
    }
    activate(f->s->active, count, f->set, mode);
}

/* Hold those too that neither push nor open; what has just stirred is not asked again. */
static void activate_grazing(struct phase *f, struct decision *d, struct mode_change loss, int limits)
{
    for (int i = 0; i < d->count; i++) {
        const int c = d->contact[i];
        if (stays(d, i) || !d->in[i] || c == loss.contact || fabs(f->rates[c]) > rest_velocity(f, c) ||
            fabs(gap_acceleration(d, i, d->P)) > PRESSED * d->scale || fixed(d, i, f->s->active->mode))
            continue;
        d->touches[i] = 1;
        activate_staying(f, d, limits);
    }
}

enum outcome activate_selected(struct phase *f, struct decision *d, struct mode_change loss)
{
    struct active_set *h = f->s->active;
    const int gives = loss.how == SLIPS_FORWARD || loss.how == SLIPS_BACKWARD;
    activate_staying(f, d, gives);
    activate_grazing(f, d, loss, gives);
    for (int i = 0; i < h->count; i++)
        h->closed[h->set[i]] = PUSHING;
    for (int i = 0; i < d->count; i++)
        if (d->stands[i] || (h->count && !stays(d, i) && fixed(d, i, h->mode))) {
            h->closed[d->contact[i]] = CARRIED;
            h->twin[d->contact[i]] = d->twin[i] >= 0 && stays(d, d->twin[i]) ? d->contact[d->twin[i]] : -1;
            h->implied++;
        }
    if (h->rows <= h->count)
        return OUTCOME_DONE;
    struct arena *arena = f->s->arena;
    const struct mark mark = arena->top;
    double *values = TAKE(arena, double, switching_count(f->s));
    enum outcome outcome = OUTCOME_NO_MEMORY;
    int over = 0;
    if (arena->ran_out)
        goto end;
    outcome = switching_functions(f->s, f->t, f->y, f->dy, values);
    for (int w = h->count; w < switching_count(f->s); w++)
        over |= mode_change_of(f->s, w).how != SLIP_ENDS && mode_change_of(f->s, w).how != BEARS && values[w] < 0.0;
    if (over)
        activate_staying(f, d, 1);
end:
    give_back(arena, mark);
    return outcome;
}
