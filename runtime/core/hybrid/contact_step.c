/* One step of time stepping: contacts without events (docs/theory, section 5.11, eq. 5.17).
 *
 * A step of length h looks at the contacts once, in its middle, and gives them the impulse of the whole step, of forces and impacts
 * alike (J. J. Moreau's midpoint rule; M. Jean, "The non-smooth contact dynamics method", 1999, section 5):
 *
 *     q_m = q + h/2 u,    u_f = u + h a_m,    u+ = u_f + M^-1 (N^T P + T^T F)  by the law of impact,    q+ = q_m + h/2 u+,
 *
 * where a_m are the accelerations in the middle without contacts. Impulses have a solution where forces have none or several
 * (Painleve), and nothing accumulates: however many events a step has, it ends. Loops and closed contacts are then put back at
 * position and velocity level, and the energy may not rise. It is of first order: what a step does not see, it moves by no more than itself.
 * So where the run can go on from event to event, it does.
 */
#include "hybrid/contact_step.h"

#include <math.h>
#include <string.h>

#include "base/tolerances.h"
#include "base/within.h"
#include "constraints/impulse.h"
#include "hybrid/immovable.h"
#include "impact/impact.h"
#include "model/contacts.h"
#include "model/scales.h"
#include "motion/derivative.h"
#include "motion/projection.h"

enum { HALVINGS = 30 /* of a part of restitution */ };

/* Part of a step, a power of two: what is shorter moves nothing */
static const double SHORTEST_PIECE = 0x1p-20;

int take_step_room(const struct system *s, struct step_room *r)
{
    struct arena *arena = s->arena;
    const size_t n = s->n, c = s->model->contacts;
    *r = (struct step_room){
        .middle = TAKE_ZEROS(arena, double, s->size),
        .dy = TAKE(arena, double, s->size),
        .free = TAKE(arena, double, n),
        .u = TAKE(arena, double, n),
        .momentum = TAKE(arena, double, n),
        .before = TAKE(arena, double, c),
        .after = TAKE(arena, double, c),
        .e = TAKE(arena, double, c),
        .less = TAKE(arena, double, c),
        .P = TAKE(arena, double, 2 * c),
        .from = TAKE(arena, double, s->size),
        .whole = TAKE(arena, double, s->size),
        .half = TAKE(arena, double, s->size),
        .held = TAKE(arena, int, c),
        .put = TAKE(arena, int, c),
        .mode = TAKE(arena, signed char, c),
    };
    for (size_t i = 0; !arena->ran_out && i < c; i++)
        r->mode[i] = FRICTIONLESS;
    return arena->ran_out;
}

/* Hold the contacts set[count], without friction, and no others. */
static void hold(struct system *s, int count, const int *set, const struct step_room *r)
{
    if (s->active)
        activate(s->active, count, set, r->mode);
}

static double kinetic(const struct system *s, const double *q, const double *u, double *momentum)
{
    double twice = 0.0;
    s->model->momentum(s->k, q, u, momentum);
    for (int i = 0; i < s->n; i++)
        twice += u[i] * momentum[i];
    return 0.5 * twice;
}

static double energy_of(const struct system *s, const double *y, double *kinetic_energy)
{
    double energy[2];
    s->model->energy(s->k, y, y + s->n, energy);
    *kinetic_energy = energy[0];
    return energy[0] + energy[1];
}

/* The velocities r->free after a step of length h without contacts, by the accelerations in its middle */
static enum outcome fly(struct phase *f, struct step_room *r, double t, double h, const double *y)
{
    struct system *s = f->s;
    const int n = s->n;
    double *q = r->middle, *u = r->middle + n;
    enum outcome outcome = system_derivative(s, t, y, r->dy);
    for (int i = 0; i < n; i++) {
        q[i] = y[i] + 0.5 * h * y[n + i];
        u[i] = y[n + i] + 0.5 * h * r->dy[n + i];
    }
    outcome = outcome ? outcome : project_position(s, q);
    outcome = outcome ? outcome : project_velocity(s, q, u);
    outcome = outcome ? outcome : system_derivative(s, t + 0.5 * h, r->middle, r->dy);
    for (int i = 0; i < n; i++)
        r->free[i] = y[n + i] + h * r->dy[n + i];
    return outcome ? outcome : project_velocity(s, q, r->free);
}

/* Whether a contact has had no room for many events in a row */
static int has_no_room(const struct phase *f, int contact)
{
    return f->tight[contact] > (int)EACH && f->met[contact] > (int)ORDINARY;
}

/* Whether bounces of those that have no room are over, however fast what moves between others still is: what one would give back it would give back to within no time.
 * Where none of them loses anything they bounce on. */
static int bounces_are_over(const struct phase *f)
{
    for (int c = 0; c < f->s->model->contacts; c++)
        if (has_no_room(f, c) && f->s->restitution[c] < 1.0)
            return 1;
    return 0;
}

/* The contacts that are closed in the middle of the step: *count of them, the set in f->set. The speed (m/s) that accelerations give
 * them in the step is in *gained: what approaches no faster than twice that rests, and has no restitution, nor has what is at the end
 * of infinitely many bounces. */
static enum outcome closed_contacts(struct phase *f, struct step_room *r, const double *u, double *gained, int *count)
{
    struct system *s = f->s;
    *gained = 0.0;
    *count = 0;
    if (!s->model->contacts)
        return OUTCOME_DONE;
    contact_gaps(s, r->middle, f->gaps);
    contact_rates(s, r->middle, u, r->before);
    contact_rates(s, r->middle, r->free, f->rates);
    for (int c = 0; c < s->model->contacts; c++)
        if (f->gaps[c] <= gap_tolerance(f, c)) {
            f->set[(*count)++] = c;
            *gained = fmax(*gained, fabs(f->rates[c] - r->before[c]));
        }
    const enum outcome outcome = leave_out_immovable(f, r->middle, count, f->set);
    const int over = bounces_are_over(f);
    for (int i = 0; i < *count; i++) {
        const int c = f->set[i], strikes = r->before[c] < -2.0 * *gained;
        r->e[i] = strikes && !(over && has_no_room(f, c)) ? s->restitution[c] : 0.0;
    }
    return outcome;
}

/* Impulses at `count` contacts, of restitution r->less: r->u and r->P. Where none meets Coulomb's law to its digits, as where contacts press each
 * other with what moves next to nothing, they miss it by a small part of what approaches, by far less than the step itself does. */
static enum outcome strike(struct phase *f, struct step_room *r, const double *q, const double *u, int count)
{
    struct system *s = f->s;
    s->law_missed = SWEPT_MISS;
    const enum outcome outcome = impact(s, q, u, count, f->set, r->less, r->u, r->P);
    s->law_missed = 0.0;
    return outcome;
}

/* What the impulses that are taken, from velocities u to r->u at q, add to the energy: r->jump. The step began with velocities u_begin; impulses that act all along it do their
 * work at the mean of u_begin and r->u. Counted from u, where loads have acted without them, it would be off by half of what they do along the accelerations, which is of first
 * order. Of what the energy loses it is as much as the impulses of the contacts work: near dependent rows the loops' own impulses add and take energy too, by rounding, and the
 * work of impulses that are as large as 1 / sigma is rounding itself; what either is beyond the other is an error of the step. Driven joints do work beside the contacts, and
 * what both do is known by the change alone. */
static void note_jump(const struct phase *f, struct step_room *r, int count, const double *q, const double *u,
                      const double *u_begin)
{
    const struct system *s = f->s;
    double lost = kinetic(s, q, u, r->momentum) - kinetic(s, q, r->u, r->momentum);
    for (int i = 0; i < s->n; i++)
        r->dy[i] = r->u[i] - u[i];
    s->model->momentum(s->k, q, r->dy, r->momentum);
    for (int i = 0; i < s->n; i++)
        lost += 0.5 * r->momentum[i] * (u[i] - u_begin[i]);
    contact_rates(s, q, u_begin, r->before);
    const double taken = contacts_take(s, q, count, f->set, r->P, r->before, u_begin, r->u, r->after);
    r->jump -= s->model->drives ? lost : fmax(0.0, fmin(lost, taken));
}

/* The impulses of the step at `count` contacts, with `share` of their restitution: r->u */
static enum outcome push_with(struct phase *f, struct step_room *r, int count, double share)
{
    for (int i = 0; i < count; i++)
        r->less[i] = share * r->e[i];
    return strike(f, r, r->middle, r->free, count);
}

/* Whether these have no more energy than the velocities r->free, which is `most`. Driven joints do work in an impact too: beside them it is what contacts do
 * that may not add any, which the impact has seen to. */
static int is_no_gain(const struct phase *f, const struct step_room *r, double most)
{
    return f->s->model->drives || kinetic(f->s, r->middle, r->u, r->momentum) <= most;
}

/* and with the largest part of it that does not add to their energy */
static enum outcome push(struct phase *f, struct step_room *r, int count)
{
    const double most = kinetic(f->s, r->middle, r->free, r->momentum);
    enum outcome outcome = push_with(f, r, count, 1.0);
    if (!outcome && is_no_gain(f, r, most))
        return OUTCOME_DONE;
    if (outcome == OUTCOME_NO_MEMORY || outcome == OUTCOME_INTERRUPTED || outcome == OUTCOME_INEXACT)
        return outcome;
    if (f->run->on_gain == GAIN_STOPS && (!outcome || outcome == OUTCOME_GAINED))
        return OUTCOME_GAINED;
    double below = 0.0, above = 1.0;
    for (int i = 0; i < HALVINGS; i++) {
        const double middle = 0.5 * (below + above);
        const int more = push_with(f, r, count, middle) || !is_no_gain(f, r, most);
        *(more ? &above : &below) = middle;
    }
    outcome = push_with(f, r, count, below);
    return outcome == OUTCOME_GAINED ? OUTCOME_DONE : outcome; /* rounding: the whole step is looked at again */
}

/* Put y1 onto the closure, the gaps of r->put[count] onto their grounds, and no other behind its own: those are put there too, but they
 * move as they do. */
static enum outcome put_onto(struct phase *f, struct step_room *r, int count, double *y1)
{
    struct system *s = f->s;
    for (int pass = 0; pass <= s->model->contacts; pass++) {
        hold(s, count, r->put, r);
        const enum outcome outcome = project_position(s, y1);
        if (outcome || !s->model->contacts)
            return outcome;
        contact_gaps(s, y1, f->gaps);
        int deepest = -1;
        for (int c = 0; c < s->model->contacts; c++)
            if (f->gaps[c] < -PLACE_ROUNDING * s->model->links * s->extent[c] &&
                (deepest < 0 || f->gaps[c] < f->gaps[deepest]))
                deepest = c;
        for (int i = 0; i < count && deepest >= 0; i++)
            if (r->put[i] == deepest)
                return f->gaps[deepest] < -SHUT * s->extent[deepest] ? OUTCOME_NOT_CLOSED : OUTCOME_DONE;
        if (deepest < 0)
            break;
        r->put[count++] = deepest;
    }
    return OUTCOME_DONE;
}

/* The same of the contacts r->held[count]. A prescribed motion may leave no place where they and what is behind its ground are all on theirs, as where a joint between two feet
 * comes down: then what is behind is put there alone, and they give way. */
static enum outcome put_back(struct phase *f, struct step_room *r, int count, double *y1)
{
    const size_t bytes = f->s->n * sizeof *y1;
    memcpy(r->put, r->held, count * sizeof *r->put);
    memcpy(r->dy, y1, bytes);
    const enum outcome outcome = put_onto(f, r, count, y1);
    if (outcome != OUTCOME_NOT_CLOSED || !f->s->model->drives || !count)
        return outcome;
    memcpy(y1, r->dy, bytes);
    return put_onto(f, r, 0, y1);
}

/* Bring the contacts r->held[count] to rest along their normals at y1, whose velocities keep the loops shut: that too is an impulse of contacts. */
static enum outcome hold_still(struct phase *f, struct step_room *r, int count, double *y1)
{
    struct system *s = f->s;
    double *u = y1 + s->n;
    if (!count)
        return OUTCOME_DONE;
    const double before = kinetic(s, y1, u, r->momentum);
    hold(s, count, r->held, r);
    const enum outcome outcome = project_velocity(s, y1, u);
    hold(s, 0, NULL, r);
    r->jump += kinetic(s, y1, u, r->momentum) - before;
    return outcome;
}

/* Bring to rest what is closed at y1 and approaches no faster than `slow`. */
static enum outcome stop_slow(struct phase *f, struct step_room *r, double slow, double *y1)
{
    struct system *s = f->s;
    double *u = y1 + s->n;
    int count = 0, approaching = 0;
    if (!s->model->contacts)
        return OUTCOME_DONE;
    const double speed = fastest(s, u);
    contact_gaps(s, y1, f->gaps);
    contact_rates(s, y1, u, f->rates);
    for (int c = 0; c < s->model->contacts; c++)
        if (f->gaps[c] <= SHUT * s->extent[c] && fabs(f->rates[c]) <= slow) {
            approaching |= f->rates[c] < -ROUNDED_RATE * speed * s->extent[c];
            r->less[count] = 0.0;
            f->set[count++] = c;
        }
    if (!approaching)
        return OUTCOME_DONE;
    enum outcome outcome = leave_out_immovable(f, y1, &count, f->set);
    if (outcome || !count)
        return outcome;
    outcome = strike(f, r, y1, u, count);
    if (!outcome || outcome == OUTCOME_GAINED) {
        note_jump(f, r, count, y1, u, u);
        memcpy(u, r->u, s->n * sizeof *u);
    }
    return outcome == OUTCOME_GAINED ? OUTCOME_DONE : outcome;
}

/* Whether the energy at y1 is no more than `most`, velocities being slowed down to that if they need be. A place that is put back has `rounding`. */
static int keeps(const struct system *s, double most, double rounding, double *y1)
{
    double moving;
    const double found = energy_of(s, y1, &moving), rest = found - moving;
    if (found <= most)
        return 1;
    if (!(rest <= most + rounding))
        return 0;
    const double part = most > rest && moving > 0.0 ? sqrt((most - rest) / moving) : 0.0;
    for (int i = 0; i < s->n; i++)
        y1[s->n + i] *= part;
    return 1;
}

/* Whether the energy at y1 misses what is to be there by too much of what moves: where a drive forces links through a line, their velocities have no bound, and those after a
 * step are no motion. */
static int goes_astray(const struct phase *f, const struct step_room *r, double expected, const double *y1)
{
    double moving;
    const double found = energy_of(f->s, y1, &moving);
    return f->run->method->order && fabs(found - expected) > DRIVEN_ASTRAY * (r->scale + moving);
}

/* Slow down what drives leave free at y1, so that the energy is no more than `most` if that can be: velocities are those of least energy that drives let
 * be, and others, which add to it by themselves, as M-orthogonal parts do. */
static enum outcome keep_beside_drives(struct system *s, struct step_room *r, double most, double *y1)
{
    const struct mark mark = s->arena->top;
    double *u = y1 + s->n, *du = r->free, moving;
    const double found = energy_of(s, y1, &moving);
    if (found <= most)
        return OUTCOME_DONE;
    double *f = TAKE(s->arena, double, s->n), *closed = TAKE_ZEROS(s->arena, double, s->model->rows);
    double *multipliers = TAKE(s->arena, double, s->model->rows);
    enum outcome outcome = s->arena->ran_out ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    if (!outcome) {
        s->model->momentum(s->k, y1, u, f);
        for (int i = 0; i < s->n; i++)
            f[i] = -f[i];
        outcome = system_impulse(s, y1, f, closed, RANK_TOLERANCE, du, multipliers);
    }
    if (!outcome) {
        const double open = kinetic(s, y1, du, r->momentum);
        const double left = open > 0.0 ? sqrt(fmax(0.0, 1.0 - (found - most) / open)) : 1.0;
        for (int i = 0; i < s->n; i++)
            u[i] += (1.0 - left) * du[i];
    }
    give_back(s->arena, mark);
    return outcome;
}

/* Work (J) of the effects over the step, at the velocity that moves it: contacts are apart */
static enum outcome work_of_effects(struct phase *f, struct step_room *r, double t, double h, const double *y,
                                    const double *y1, double *done)
{
    struct system *s = f->s;
    const int n = s->n;
    if (!s->model->power)
        return OUTCOME_DONE;
    for (int i = 0; i < n; i++)
        r->middle[n + i] = 0.5 * (y[n + i] + y1[n + i]);
    const enum outcome outcome = system_derivative(s, t + 0.5 * h, r->middle, r->dy);
    *done = outcome ? 0.0 : h * r->dy[2 * n];
    return outcome;
}

/* Contacts have not taken what has not gone: strikes may take again what the free step had gained by error. */
static void keep_to_what_went(const struct system *s, struct step_room *r, double expected, const double *y1)
{
    double moving;
    if (!s->model->drives)
        r->jump = -fmin(-r->jump, fmax(0.0, expected - energy_of(s, y1, &moving)));
}

/* One step of length h from (t, y) to y1; OUTCOME_NOT_KEPT where it would go further up than its speed carries it */
static enum outcome try_step(struct phase *f, struct step_room *r, double t, double h, const double *y, double *y1)
{
    struct system *s = f->s;
    const int n = s->n;
    double gained, moving;
    const double before = energy_of(s, y, &moving);
    hold(s, 0, NULL, r);
    enum outcome outcome = fly(f, r, t, h, y);
    if (outcome)
        return outcome;
    int count;
    if ((outcome = closed_contacts(f, r, y + n, &gained, &count)))
        return outcome;
    memcpy(r->u, r->free, n * sizeof *r->u);
    r->jump = 0.0;
    if (count) {
        if ((outcome = push(f, r, count)))
            return outcome;
        note_jump(f, r, count, r->middle, r->free, y + n);
    }
    int held = 0;
    if (count)
        contact_rates(s, r->middle, r->u, f->rates);
    for (int i = 0; i < count; i++)
        if (r->P[i] > 0.0 && fabs(f->rates[f->set[i]]) <= gained)
            r->held[held++] = f->set[i];
    for (int i = 0; i < n; i++) {
        y1[i] = r->middle[i] + 0.5 * h * r->u[i];
        y1[n + i] = r->u[i];
    }
    outcome = put_back(f, r, held, y1);
    hold(s, 0, NULL, r);
    outcome = outcome ? outcome : project_velocity(s, y1, y1 + n);
    outcome = outcome ? outcome : hold_still(f, r, held, y1);
    outcome = outcome ? outcome : stop_slow(f, r, 2.0 * gained, y1);
    if (outcome)
        return outcome;
    double done = 0.0;
    if ((outcome = work_of_effects(f, r, t, h, y, y1, &done)))
        return outcome;
    if (s->model->drives)
        outcome = goes_astray(f, r, before + done + r->jump, y1)
                      ? OUTCOME_NO_CONVERGENCE
                      : keep_beside_drives(s, r, before + done + r->jump, y1);
    else if (!keeps(s, before + done, ENERGY_ROUNDING * (r->scale + fabs(before)), y1))
        outcome = OUTCOME_NOT_KEPT;
    if (outcome)
        return outcome;
    if (!all_finite(2 * (size_t)n, y1))
        return OUTCOME_NOT_FINITE;
    keep_to_what_went(s, r, before + done, y1);
    if (s->size > 2 * n)
        y1[2 * n] = y[2 * n] + done;
    return OUTCOME_DONE;
}

/* Whether what moves at y is no more than rounding of a step may be: at rest, for a piece of it */
static int hardly_moves(const struct phase *f, const struct step_room *r, const double *y)
{
    double moving;
    energy_of(f->s, y, &moving);
    return moving <= STEPPED * STEPPED * r->scale;
}

enum outcome step_once(struct phase *f, struct step_room *r, double t, double h, const double *y, double *y1)
{
    const size_t bytes = f->s->size * sizeof *y;
    double done = 0.0, piece = 1.0, jump = 0.0;
    memcpy(r->from, y, bytes);
    while (done < 1.0) {
        if (interrupted(f->s->interruption, f->s->n))
            return OUTCOME_INTERRUPTED;
        const enum outcome outcome = try_step(f, r, t + done * h, piece * h, r->from, y1);
        if (outcome == OUTCOME_NOT_KEPT && piece > SHORTEST_PIECE)
            piece *= 0.5;
        else if (outcome == OUTCOME_NOT_KEPT && hardly_moves(f, r, r->from)) {
            memcpy(y1, r->from, bytes);
            memset(y1 + f->s->n, 0, f->s->n * sizeof *y1);
            break;
        } else if (outcome)
            return outcome;
        else {
            jump += r->jump;
            done += piece;
            memcpy(r->from, y1, bytes);
            piece = fmod(done, 2.0 * piece) == 0.0 ? 2.0 * piece : piece;
        }
    }
    r->jump = jump;
    return OUTCOME_DONE;
}
