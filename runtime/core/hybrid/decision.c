/* What decides which closed contacts are held: their accelerations b without forces between them, their compliances W.
 *
 * Where forces vanish together (vanishing.c), P = 0 and z = 0 at their contacts, and the next order decides: the same problem
 * with a small part of the change that b takes along the motion, in place of what rounding has left of those forces. The problem
 * is the same at every size of b. So where nothing else presses, b is enlarged to the size of other accelerations, but
 * its rounding to no more than what counts as none: what is small is then not taken for nothing.
 */
#include "hybrid/decision.h"

#include <math.h>

#include "base/tolerances.h"
#include "constraints/branch.h"
#include "constraints/delassus.h"
#include "motion/derivative.h"
#include "model/contacts.h"

int take_decision(struct decision *d, struct system *s)
{
    const size_t c = s->model->contacts, rows = 2 * c;
    struct arena *arena = s->arena;
    *d = (struct decision){
        .contact = TAKE(arena, int, c),
        .in = TAKE_ZEROS(arena, char, c),
        .mode = TAKE_ZEROS(arena, signed char, c),
        .given = TAKE_ZEROS(arena, char, c),
        .touches = TAKE_ZEROS(arena, char, c),
        .stands = TAKE_ZEROS(arena, char, c),
        .twin = TAKE(arena, int, c),
        .b = TAKE(arena, double, rows),
        .P = TAKE(arena, double, rows),
        .W = TAKE(arena, double, (rows * rows)),
        .trial = TAKE(arena, double, rows),
        .modes = TAKE_ZEROS(arena, signed char, c),
        .was = TAKE_ZEROS(arena, signed char, c),
        .mu = s->friction,
        .enlarged = 1.0,
        .vanishing = {.zero = TAKE_ZEROS(arena, char, c), .force = TAKE(arena, double, rows)},
        .part =
            {
                .row = TAKE(arena, int, rows),
                .W = TAKE(arena, double, (rows * rows)),
                .b = TAKE(arena, double, rows),
                .x = TAKE(arena, double, rows),
                .mu = TAKE(arena, double, c),
                .mode = TAKE(arena, signed char, c),
            },
    };
    take_semidefinite(arena, &d->part.room, rows);
    for (size_t i = 0; i < c && !arena->ran_out; i++)
        d->twin[i] = -1;
    return arena->ran_out;
}

/* Accelerations of all contacts without forces between them, of gaps or of sliding, into out[contacts], with the derivative dy
 * of the state y. */
static void free_accelerations(const struct system *s, const double *y, const double *dy, int sliding, double *out,
                               double *more)
{
    if (!sliding) {
        contact_rates(s, y, dy + s->n, out);
        contact_bias(s, y, y + s->n, more);
        return;
    }
    s->model->slips(s->k, y, dy + s->n, out);
    s->model->slip_bias(s->k, y, y + s->n, more);
}

/* What b, of the contacts in question, changes by to the state ahead: change[all] */
static enum outcome change_ahead(struct phase *f, const struct decision *d, double *change)
{
    struct system *s = f->s;
    const int n = d->count;
    const struct mark mark = s->arena->top;
    double *rates = TAKE(s->arena, double, s->model->contacts), *bias = TAKE(s->arena, double, s->model->contacts);
    enum outcome outcome = OUTCOME_NO_MEMORY;
    if (!s->arena->ran_out)
        outcome = system_derivative(s, f->t + d->vanishing.ahead, f->y1, f->dy1);
    for (int sliding = 0; sliding < d->all / n && !outcome; sliding++) {
        free_accelerations(s, f->y1, f->dy1, sliding, rates, bias);
        for (int i = 0; i < n; i++)
            change[sliding * n + i] = rates[d->contact[i]] + bias[d->contact[i]] - d->b[sliding * n + i];
    }
    give_back(s->arena, mark);
    return outcome;
}

/* Put in place of what is left of the forces that vanish a small part of the change of b, which decides on them. */
static void go_ahead(const struct system *s, struct decision *d, const double *change)
{
    const struct vanishing *v = &d->vanishing;
    const int n = d->count;
    double largest = 0.0, base = 0.0, found = 0.0;
    for (int i = 0; i < d->all; i++)
        for (int j = 0; j < d->all; j++)
            if (v->zero[d->contact[j % n]])
                d->b[i] += d->W[i * d->all + j] * v->force[d->contact[j % n] + (j < n ? 0 : s->model->contacts)];
    for (int i = 0; i < n; i++) {
        base = fmax(base, fabs(d->b[i]));
        largest = fmax(largest, v->zero[d->contact[i]] ? fabs(change[i]) : 0.0);
    }
    const double part = base > v->noise && largest > 0.0 ? fmin(1.0, ONWARD * base / largest) : 1.0;
    for (int i = 0; i < d->all; i++)
        d->b[i] += part * change[i];
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
}

/* The accelerations of all contacts without forces between them */
struct accelerations {
    double *rates, *bias, *slips; /* [contacts] */
    double *change;               /* [2 contacts] */
    double *columns;              /* [2 contacts][n] */
};

static void take_accelerations(const struct system *s, struct accelerations *a)
{
    const size_t contacts = s->model->contacts;
    a->rates = TAKE(s->arena, double, contacts);
    a->bias = TAKE(s->arena, double, contacts);
    a->slips = TAKE(s->arena, double, contacts);
    a->change = TAKE(s->arena, double, 2 * contacts);
    a->columns = TAKE(s->arena, double, 2 * contacts * s->n);
}

static enum outcome gather_with(struct phase *f, struct decision *d, struct accelerations *a)
{
    struct system *s = f->s;
    const struct ccgen_model *m = s->model;
    const double *q = f->y, *u = f->y + s->n;
    const struct mode_change loss = d->loss;
    const enum outcome outcome = evaluate_derivative(f);
    if (outcome)
        return outcome;
    if (s->branch && follows_at(s, f->y)) /* as it was evaluated */
        read_state_on_branch(s, f->y, f->y + s->n);
    const double *rates = a->rates, *bias = a->bias, *slips = a->slips;
    free_accelerations(s, f->y, f->dy, 0, a->rates, a->bias);
    contact_gaps(s, q, f->gaps);
    contact_rates(s, q, u, f->rates);
    d->scale = 0.0;
    for (int c = 0; c < m->contacts; c++)
        d->scale = fmax(d->scale, fabs(rates[c]) + fabs(bias[c]));
    for (int i = 0; i < s->n; i++)
        d->scale = fmax(d->scale, SHARED * (s->lengths[i] ? fabs(f->dy[s->n + i])
                                                          : s->length * (fabs(f->dy[s->n + i]) + u[i] * u[i])));
    const double soon = SLOW * REST_TIME * fmax(s->time, fabs(f->t)) * d->scale;
    for (int c = 0; c < m->contacts; c++)
        if (f->gaps[c] <= SHUT * s->extent[c] && fabs(f->rates[c]) <= fmax(soon, rest_velocity(f, c)) &&
            !(d->opens && d->opens[c])) {
            d->in[d->count] = !(c == loss.contact && loss.how == DETACHES);
            d->b[d->count] = rates[c] + bias[c];
            d->contact[d->count++] = c;
        }
    d->all = s->friction ? 2 * d->count : d->count;
    if (s->friction && d->count) {
        free_accelerations(s, f->y, f->dy, 1, a->rates, a->bias);
        m->slips(s->k, q, u, a->slips);
        for (int i = 0; i < d->count; i++) {
            const int c = d->contact[i];
            d->b[d->count + i] = rates[c] + bias[c];
            const int slow_rests = f->at.slow > 0.0 && !(d->moves && d->moves[c]);
            const double still = slow_rests ? rest_velocity(f, c) : STILL * s->length / s->time;
            d->mode[i] = s->friction[c] == 0.0 || fabs(slips[c]) <= still ? 0 : slips[c] > 0.0 ? 1 : -1;
            if (c == loss.contact && loss.how != DETACHES && loss.how != LOADS)
                d->mode[i] = 0;
            d->given[i] = loss.how == SLIPS_FORWARD || loss.how == SLIPS_BACKWARD;
        }
    }
    enum outcome found = delassus(s, q, d->count, d->contact, a->columns, d->W);
    const double missed = missed_force(s, f->y);
    d->scale = fmax(d->scale, force_noise(s, d->count, d->contact, d->W, d->all + 1) / PRESSED);
    for (int i = 0; i < d->count; i++)
        d->scale = fmax(d->scale, d->W[(size_t)i * (d->all + 1)] * missed / PRESSED);
    if (found || !d->count || !(d->vanishing.ahead > 0.0))
        return found;
    found = change_ahead(f, d, a->change);
    if (!found)
        go_ahead(s, d, a->change);
    return found;
}

enum outcome gather_candidates(struct phase *f, struct decision *d)
{
    struct system *s = f->s;
    const struct mark mark = s->arena->top;
    struct accelerations a;
    take_accelerations(s, &a);
    const enum outcome outcome = s->arena->ran_out ? OUTCOME_NO_MEMORY : gather_with(f, d, &a);
    give_back(s->arena, mark);
    return outcome;
}
