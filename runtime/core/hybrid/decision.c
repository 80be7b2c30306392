/* What decides which closed contacts are held: their accelerations b without forces between them, their compliances W.
 *
 * Where forces vanish together (vanishing.c), P = 0 and z = 0 at their contacts, and the next order decides: the same problem
 * with a small part of the change that b takes along the motion, in place of what rounding has left of those forces. The problem
 * is the same at every size of b. So where nothing else presses, b is enlarged to the size of other accelerations, but
 * its rounding to no more than what counts as none: what is small is then not taken for nothing.
 */
#include "hybrid/decision.h"

#include <math.h>
#include <stdlib.h>

#include "algebra/semidefinite.h"
#include "base/tolerances.h"
#include "constraints/delassus.h"
#include "motion/derivative.h"

int make_decision(struct decision *d, struct system *s)
{
    const size_t c = s->model->contacts, rows = 2 * c;
    *d = (struct decision){.mu = s->friction, .enlarged = 1.0};
    d->in = calloc(7 * c, 1);
    d->contact = malloc(3 * c * sizeof *d->contact);
    d->b = malloc((4 * rows + 2 * rows * rows + 3 * rows + 2 * c + semidefinite_scratch((int)rows)) * sizeof *d->b);
    if (!d->in || !d->contact || !d->b)
        return 1;
    d->row = d->contact + c;
    d->mode = (signed char *)d->in + c;
    d->given = d->in + 4 * c;
    d->touches = d->in + 5 * c;
    d->vanishing.zero = d->in + 6 * c;
    d->P = d->b + rows;
    d->trial = d->P + rows;
    d->vanishing.force = d->trial + rows;
    d->W = d->vanishing.force + rows;
    d->part = d->W + rows * rows;
    return 0;
}

void free_decision(struct decision *d)
{
    free(d->in);
    free(d->contact);
    free(d->b);
}

/* Accelerations of all contacts without forces between them, of gaps or of sliding, into out[contacts], with the derivative dy
 * of the state y. */
static void free_accelerations(const struct system *s, const double *y, const double *dy, int sliding, double *out,
                               double *more)
{
    (sliding ? s->model->slips : s->model->gap_rates)(s->k, y, dy + s->n, out);
    (sliding ? s->model->slip_bias : s->model->gap_bias)(s->k, y, y + s->n, more);
}

/* Put in place of what is left of the forces that vanish a small part of the change of b, which decides on them. */
static enum outcome go_ahead(struct phase *f, struct decision *d)
{
    struct system *s = f->s;
    const struct vanishing *v = &d->vanishing;
    const int n = d->count;
    double *change = d->part, *free = s->active->rates, *bias = s->active->slips, largest = 0.0, base = 0.0;
    const enum outcome outcome = system_derivative(s, f->t + v->ahead, f->y1, f->dy1);
    for (int sliding = 0; sliding < d->all / n && !outcome; sliding++) {
        free_accelerations(s, f->y1, f->dy1, sliding, free, bias);
        for (int i = 0; i < n; i++)
            change[sliding * n + i] = free[d->contact[i]] + bias[d->contact[i]] - d->b[sliding * n + i];
    }
    for (int i = 0; i < d->all && !outcome; i++)
        for (int j = 0; j < d->all; j++)
            if (v->zero[d->contact[j % n]])
                d->b[i] += d->W[i * d->all + j] * v->force[d->contact[j % n] + (j < n ? 0 : s->model->contacts)];
    for (int i = 0; i < n; i++) {
        base = fmax(base, fabs(d->b[i]));
        largest = fmax(largest, v->zero[d->contact[i]] ? fabs(change[i]) : 0.0);
    }
    const double part = base > v->noise && largest > 0.0 ? fmin(1.0, ONWARD * base / largest) : 1.0;
    for (int i = 0; i < d->all && !outcome; i++)
        d->b[i] += part * change[i];
    double found = 0.0;
    for (int i = 0; i < n; i++) {
        d->in[i] = 1;
        d->given[i] = d->given[i] && !v->zero[d->loss.contact];
        found = fmax(found, fabs(d->b[i]));
    }
    d->scale = fmax(d->scale, found);
    if (found > 0.0)
        d->enlarged = fmax(1.0, d->scale * fmin(1.0 / found, PRESSED / v->noise));
    for (int i = 0; i < d->all; i++)
        d->b[i] *= d->enlarged;
    if (v->zero[d->loss.contact] && d->loss.how != LOADS) /* what has stirred does not touch again at once */
        d->loss.contact = -1;
    return outcome;
}

enum outcome gather_candidates(struct phase *f, struct decision *d)
{
    struct system *s = f->s;
    struct active_set *h = s->active;
    const struct ccgen_model *m = s->model;
    const double *q = f->y, *u = f->y + s->n;
    const struct mode_change loss = d->loss;
    const enum outcome outcome = evaluate_derivative(f);
    if (outcome)
        return outcome;
    double *free = h->rates, *bias = h->slips, *slips = h->wanted;
    free_accelerations(s, f->y, f->dy, 0, free, bias);
    m->gaps(s->k, q, f->gaps);
    m->gap_rates(s->k, q, u, f->rates);
    d->scale = 0.0;
    for (int c = 0; c < m->contacts; c++)
        d->scale = fmax(d->scale, fabs(free[c]) + fabs(bias[c]));
    for (int i = 0; i < s->n; i++)
        d->scale = fmax(d->scale, SHARED * (s->lengths[i] ? fabs(f->dy[s->n + i])
                                                          : s->length * (fabs(f->dy[s->n + i]) + u[i] * u[i])));
    const double soon = SLOW * REST_TIME * fmax(s->time, fabs(f->t)) * d->scale;
    const double fast = fmax(soon, sqrt(2.0 * f->at.gap_uncertainty * s->length * d->scale));
    for (int c = 0; c < m->contacts; c++)
        if (f->gaps[c] <= SHUT * s->extent[c] && fabs(f->rates[c]) <= fmax(fast, rest_velocity(f, c))) {
            d->in[d->count] = !(c == loss.contact && loss.how == DETACHES);
            d->b[d->count] = free[c] + bias[c];
            d->contact[d->count++] = c;
        }
    d->all = s->friction ? 2 * d->count : d->count;
    if (s->friction && d->count) {
        free_accelerations(s, f->y, f->dy, 1, free, bias);
        m->slips(s->k, q, u, slips);
        for (int i = 0; i < d->count; i++) {
            const int c = d->contact[i];
            d->b[d->count + i] = free[c] + bias[c];
            d->mode[i] = s->friction[c] == 0.0 || fabs(slips[c]) <= STILL * s->length / s->time ? 0
                         : slips[c] > 0.0                                                       ? 1
                                                                                                : -1;
            if (c == loss.contact && loss.how != DETACHES && loss.how != LOADS)
                d->mode[i] = 0;
            d->given[i] = loss.how == SLIPS_FORWARD || loss.how == SLIPS_BACKWARD;
        }
    }
    const enum outcome found =
        delassus(s, q, d->count, d->contact, h->columns, d->W, h->units, h->answers, h->pushes, h->rates, h->f);
    d->scale = fmax(d->scale, force_noise(s, d->count, d->contact, d->W, d->all + 1) / PRESSED);
    return !found && d->count && d->vanishing.ahead > 0.0 ? go_ahead(f, d) : found;
}
