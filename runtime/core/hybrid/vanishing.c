/* Forces of held contacts that vanish together.
 *
 * A body that rests on several points and is lifted evenly loses all their forces at one instant. Found one by one, the events
 * lie within rounding of each other, and at the first of them the other forces are rounding: their signs say nothing. There
 * P = 0 and gaps do not accelerate, and what follows is decided by the next order (docs/theory, section 5.6): by how zeta, which is
 * b here, changes along the motion, on which all ways to go on agree to that order, so that the contacts may be held a little longer to see it.
 *
 * Whether a force P has vanished: it will have, at its rate P', within P / |P'|. Let go now, its gap gets a speed of
 * W P (P / |P'|) / 2 meanwhile. Where that is a small part of the tolerance, and where gaps are not known to what it moves in
 * that time, it makes no difference whether the contact is let go now or then.
 * Where forces neither rise nor fall, as at the least of one that comes back, what is left is their rounding, told by the forces
 * that there have been.
 */
#include "hybrid/vanishing.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "base/tolerances.h"
#include "constraints/delassus.h"
#include "motion/derivative.h"
#include "steps/step_end.h"

double force_noise(const struct system *s, int count, const int *set, const double *W, int step)
{
    double found = 0.0;
    for (int i = 0; i < count; i++)
        found = fmax(found, W[(size_t)i * step] * s->active->peak[set[i]]);
    return FORCE_ROUNDING * found;
}

/* Whether the force of held contact i may be among those that vanish. What touches without pressing does so until it stirs. */
static int may_vanish(const struct active_set *h, int i, struct mode_change loss)
{
    double largest = 0.0;
    for (int j = 0; j < h->count; j++)
        largest = fmax(largest, h->peak[h->set[j]]);
    return (h->mode[i] != GRAZING || loss.how == LOADS) && fabs(h->force[i]) <= SMALL * largest;
}

/* Whether others than the one that is lost may have vanished: else there is nothing to find out. */
static int several(const struct active_set *h, struct mode_change loss)
{
    int count = 0;
    for (int i = 0; i < h->count; i++)
        count += may_vanish(h, i, loss) && !(h->set[i] == loss.contact && loss.how == DETACHES);
    return count > 0;
}

/* Whether it makes no difference that contact c is let go although it is pressed by a, an acceleration that vanishes at `rate` */
static int gone(const struct phase *f, int c, double a, double rate)
{
    const double extent = f->s->extent[c];
    return a * a <= 2.0 * LITTLE * f->run->tolerance.atol / f->s->time * extent * rate &&
           a * a * a <= 2.0 * PLACE_ROUNDING * extent * rate * rate;
}

/* The forces h->force by contact, those of friction too */
static void note_forces(const struct system *s, double *force)
{
    const struct active_set *h = s->active;
    const int contacts = s->model->contacts;
    memset(force, 0, 2 * (size_t)contacts * sizeof *force);
    for (int i = 0; i < h->count; i++) {
        force[h->set[i]] = h->force[i];
        if (against(h->mode[i]))
            force[contacts + h->set[i]] = -against(h->mode[i]) * s->friction[h->set[i]] * h->force[i];
    }
    for (int row = h->count; row < h->rows; row++)
        force[contacts + h->set[h->of[row]]] = h->force[row];
}

/* Follow the held motion by h to f->y1: h->force is then what it has come to. */
static enum outcome follow(struct phase *f, double h)
{
    const int follows = f->at.follows;
    enum outcome outcome = projected_step(f, h);
    outcome = outcome ? outcome : system_derivative(f->s, f->t + h, f->y1, f->dy1);
    leave_branch(f); /* the decision begins one anew */
    f->at.follows = follows;
    return outcome;
}

/* The largest change of a force since `force`, as an acceleration */
static double largest_change(const struct active_set *h, const double *force, const double *W, int step)
{
    double found = 0.0;
    for (int i = 0; i < h->count; i++)
        found = fmax(found, W[(size_t)i * step] * fabs(h->force[i] - force[h->set[i]]));
    return found;
}

/* Follow the held motion until forces have changed by more than rounding, not for longer than they are known to be smooth. The
 * first order that is more than rounding decides: one further ahead may have turned already. */
static enum outcome look_ahead(struct phase *f, struct vanishing *v, const double *W, int step)
{
    const double least = sqrt(2.0 * PLACE_ROUNDING * f->s->length * FORCE_ROUNDING / v->noise);
    const double kink = next_kink(f->run, f->t) - f->t, most = fmax(AHEAD * f->h, least);
    const double last = fmin(most, kink);
    for (double ahead = fmin(least, last);; ahead = fmin(FURTHER_AHEAD * ahead, last)) {
        const enum outcome outcome = isfinite(ahead) ? follow(f, ahead) : OUTCOME_NOT_FINITE;
        if (outcome)
            return outcome;
        v->ahead = ahead;
        if (ahead >= last || largest_change(f->s->active, v->force, W, step) > DECISIVE * v->noise)
            return OUTCOME_DONE;
    }
}

/* Which forces have vanished, W[rows][rows] being the compliances; whether others have than the one that is lost */
static int note_vanished(const struct phase *f, struct mode_change loss, struct vanishing *v, const double *W, int rows)
{
    const struct active_set *h = f->s->active;
    int others = 0;
    for (int i = 0; i < h->count; i++) {
        const int c = h->set[i];
        const double own = W[(size_t)i * (rows + 1)], p = fabs(v->force[c]),
                     rate = (h->force[i] - v->force[c]) / v->ahead;
        if ((h->mode[i] == GRAZING && loss.how != LOADS) || p * own > SMALL * v->noise / FORCE_ROUNDING)
            continue;
        v->zero[c] = p * own <= v->noise || gone(f, c, own * p, own * fabs(rate));
        others += v->zero[c] && !(c == loss.contact && loss.how == DETACHES);
    }
    return others;
}

enum outcome find_vanishing(struct phase *f, struct mode_change loss, struct vanishing *v)
{
    struct system *s = f->s;
    struct active_set *h = s->active;
    const int rows = s->friction ? 2 * h->count : h->count;
    v->ahead = 0.0;
    memset(v->zero, 0, s->model->contacts);
    if (loss.contact < 0 || !h->count)
        return OUTCOME_DONE;
    enum outcome outcome = evaluate_derivative(f);
    if (outcome || !several(h, loss))
        return outcome == OUTCOME_INTERRUPTED ? outcome : OUTCOME_DONE;
    note_forces(s, v->force);
    const struct mark mark = s->arena->top;
    double *columns = TAKE(s->arena, double, (size_t)rows * s->n), *W = TAKE(s->arena, double, ((size_t)rows * rows));
    outcome = s->arena->ran_out ? OUTCOME_NO_MEMORY : delassus(s, f->y, h->count, h->set, columns, W);
    if (outcome)
        goto end;
    v->noise = force_noise(s, h->count, h->set, W, rows + 1);
    outcome = look_ahead(f, v, W, rows + 1);
    if (outcome || !note_vanished(f, loss, v, W, rows))
        v->ahead = 0.0;
end:
    give_back(s->arena, mark);
    return outcome == OUTCOME_INTERRUPTED || outcome == OUTCOME_NO_MEMORY ? outcome : OUTCOME_DONE;
}
