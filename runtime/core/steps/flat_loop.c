/* Gaps that rounding leaves unknown, near configurations where closure rows become dependent (docs/theory, section 8).
 *
 * Links that all but lie in a line shut their loop to second order only. Moved by dx (times length) across the row that all but
 * depends on others, at the distance sigma from dependence, the closure opens by sigma dx + dx^2. What it misses by rounding,
 * Gamma, is known; so dx is known to
 *
 *     dx = 2 Gamma / (sigma + sqrt(sigma^2 + 4 Gamma)),
 *
 * Gamma / sigma at a distance, sqrt(Gamma) where the rows depend: 5e-8 in doubles. Gaps as small as that, and impacts and forces that
 * follow from them, are rounding; their events would go on for ever.
 */
#include "steps/flat_loop.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "base/tolerances.h"
#include "constraints/impulse.h"
#include "constraints/nullspace.h"
#include "motion/derivative.h"
#include "motion/projection.h"
#include "model/contacts.h"

enum { PASSES = 20 };

/* What is unknown, times length, at the distance sigma of a closure that misses by `miss` times length (eq. 8.3) */
static double unknown(double sigma, double miss)
{
    return MARGIN * 2.0 * miss / (sigma + sqrt(sigma * sigma + 4.0 * miss));
}

/* What the closure misses, or may miss by rounding, times length; closure[rows] is scratch. */
static double closure_miss(const struct phase *f, double *closure)
{
    const struct system *s = f->s;
    double found = PLACE_ROUNDING * s->model->links;
    s->model->closure(s->k, f->y, closure);
    for (int i = 0; i < s->model->rows; i++)
        found = fmax(found, fabs(closure[i]) / s->length);
    return found;
}

/* The contacts with gaps below `gap_uncertainty` into f->set: their number, or 0 where they are closed to rounding already. */
static int uncertain_contacts(struct phase *f, double gap_uncertainty)
{
    const struct system *s = f->s;
    int count = 0, open = 0;
    contact_gaps(s, f->y, f->gaps);
    for (int c = 0; c < s->model->contacts; c++)
        if (f->gaps[c] <= gap_uncertainty * s->extent[c]) {
            open |= fabs(f->gaps[c]) > PLACE_ROUNDING * s->model->links * s->extent[c];
            f->set[count++] = c;
        }
    return open ? count : 0;
}

static double energy(const struct phase *f, const double *y)
{
    double parts[2];
    f->s->model->energy(f->s->k, y, y + f->s->n, parts);
    return parts[0] + parts[1];
}

/* Whether y1 has the energy of y but for a small part of what is in motion: velocities that do not lead to a place where rows are
 * lost are not to be lost without an impact. None is gained: velocities nearest to given ones, as projections find them, have no more kinetic
 * energy than those. Where no motion is nearest but in rounding, the quotient of two roundings may be anything. */
static int keeps_energy(const struct phase *f)
{
    double parts[2], given[2], found[2];
    const int n = f->s->n;
    f->s->model->energy(f->s->k, f->y, f->y + n, parts);
    f->s->model->energy(f->s->k, f->y1, f->y + n, given);
    f->s->model->energy(f->s->k, f->y1, f->y1 + n, found);
    const double moves = fmax(f->at.energy_in_motion, parts[0]);
    return found[0] + found[1] >= parts[0] + parts[1] - ENERGY_ASTRAY * moves &&
           found[0] <= given[0] + ENERGY_ADDED * moves;
}

/* Put y1, a copy of the state, where the contacts f->set are closed; whether there is such a place, with rows of the closure
 * lost, nothing behind its surface, and no energy added but by lifting what is behind its surface. closure[rows] is scratch. */
static int closes_contacts(struct phase *f, int count, double miss, int rank, double *closure)
{
    struct system *s = f->s;
    double nearest;
    memcpy(f->y1, f->y, (size_t)s->size * sizeof *f->y);
    if (project_position(s, f->y1) || row_rank(s, f->y1, &nearest) >= rank)
        return 0;
    s->model->closure(s->k, f->y1, closure);
    for (int i = 0; i < s->model->rows; i++)
        if (!(fabs(closure[i]) <= miss * s->length))
            return 0;
    int behind = 0;
    for (int i = 0; i < count; i++)
        behind |= f->gaps[f->set[i]] < -PLACE_ROUNDING * s->model->links * s->extent[f->set[i]];
    contact_gaps(s, f->y1, f->gaps);
    for (int c = 0; c < s->model->contacts; c++)
        if (!(f->gaps[c] >= -SHUT * s->extent[c]))
            return 0;
    for (int i = 0; i < count; i++)
        if (f->gaps[f->set[i]] > SHUT * s->extent[f->set[i]])
            return 0;
    const double before = energy(f, f->y);
    return behind || energy(f, f->y1) <= before + ENERGY_ADDED * fabs(before);
}

/* The largest acceleration of a gap at y1 without forces between contacts; negative where there is none */
static double falling(struct phase *f)
{
    struct system *s = f->s;
    const struct mark mark = s->arena->top;
    double *rates = TAKE(s->arena, double, s->model->contacts), *bias = TAKE(s->arena, double, s->model->contacts);
    double found = s->arena->ran_out || system_derivative(s, f->t, f->y1, f->dy1) ? -1.0 : 0.0;
    if (found < 0.0)
        goto end;
    contact_rates(s, f->y1, f->dy1 + s->n, rates);
    contact_bias(s, f->y1, f->y1 + s->n, bias);
    for (int c = 0; c < s->model->contacts; c++)
        found = fmax(found, fabs(rates[c]) + fabs(bias[c]));
end:
    give_back(s->arena, mark);
    return found;
}

/* A combination of closure rows that is lost, and what velocities do along it to second order */
struct lost_row {
    double *lambda;           /* [rows + drives] the combination */
    double *gradient;         /* [n] of what velocities open it by */
    double *du;               /* [n] M^-1 times that, with loops shut and held contacts at rest */
    double *bias;             /* [rows] scratch */
    double *still, *impulses; /* [rows + 2 contacts] zeros; scratch */
};

/* 0, or 1 when memory runs out */
static int take_lost_row(const struct system *s, struct lost_row *r)
{
    const size_t rows = s->model->rows, every = rows + 2 * (size_t)s->model->contacts;
    r->lambda = TAKE(s->arena, double, rows + s->model->drives);
    r->gradient = TAKE(s->arena, double, s->n);
    r->du = TAKE(s->arena, double, s->n);
    r->bias = TAKE(s->arena, double, rows);
    r->still = TAKE_ZEROS(s->arena, double, every);
    r->impulses = TAKE(s->arena, double, every);
    return s->arena->ran_out;
}

/* What velocities u open the closure by to second order, along the combination of rows that is lost (eq. 8.4: with a hat) */
static double bend(const struct system *s, const double *q, const double *u, const struct lost_row *r)
{
    double found = 0.0;
    s->model->closure_bias(s->k, q, u, r->bias);
    for (int j = 0; j < s->model->rows; j++)
        found += r->lambda[j] * r->bias[j];
    return found;
}

/* r->gradient of bend(u), and r->du. Their product, or 0. */
static double second_order_gradient(struct system *s, const double *q, double speed, double *u, struct lost_row *r)
{
    const int n = s->n, rows = active_rows(s, 1);
    double product = 0.0;
    for (int i = 0; i < n; i++) {
        const double here = u[i], step = speed * s->unit[i];
        u[i] = here + step;
        const double more = bend(s, q, u, r);
        u[i] = here - step;
        r->gradient[i] = (more - bend(s, q, u, r)) / (2.0 * step);
        u[i] = here;
    }
    if (!(speed > 0.0) || solve_in_nullspace(s, q, rows, r->still, NULL, RANK_TOLERANCE, momentum_residual, r->gradient,
                                             r->du, r->impulses))
        return 0.0;
    for (int i = 0; i < n; i++)
        product += r->gradient[i] * r->du[i];
    return fmax(product, 0.0);
}

/* Go on from y1, where the closure lets the loop be, or go. The energy that this takes is lost as in an impact of the loop with
 * itself, in which the contacts f->set do not push; not where it is less than steps may miss. */
static enum outcome commit_snap(struct phase *f, int count)
{
    struct run *run = f->run;
    double parts[2];
    f->s->model->energy(f->s->k, f->y, f->y + f->s->n, parts);
    const double loss = parts[0] + parts[1] - energy(f, f->y1);
    const double seen =
        fmax(run->tolerance.rtol * fmax(f->at.energy_in_motion, parts[0]), ENERGY_ADDED * fabs(parts[0] + parts[1]));
    const size_t n = f->s->n;
    if (record_state(f))
        return OUTCOME_NO_MEMORY;
    if (count && loss > seen) {
        const struct mark mark = f->s->arena->top;
        double *P = TAKE_ZEROS(f->s->arena, double, 2 * (size_t)count);
        const int wrong = f->s->arena->ran_out || append_impact(&run->impacts, f->t, f->y + n, f->y1 + n, n, count,
                                                                f->set, P, loss, 1.0, run->record.count);
        give_back(f->s->arena, mark);
        if (wrong)
            return OUTCOME_NO_MEMORY;
    }
    memcpy(f->y, f->y1, (size_t)f->s->size * sizeof *f->y);
    return record_state(f) ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
}

/* Bring the velocities of y1 to the nearest ones that the closure allows to second order: where rows are lost, those along which
 * the loop can go on. Whether there are such. */
static int project_to_tangent_cone(struct phase *f)
{
    struct system *s = f->s;
    const struct mark mark = s->arena->top;
    struct lost_row row;
    double *u = f->y1 + s->n;
    int done = !take_lost_row(s, &row);
    for (int number = 0; done && left_null_vector(s, f->y1, number, row.lambda); number++) {
        const double speed = fastest(s, u);
        double bent = bend(s, f->y1, u, &row);
        for (int pass = 0; pass < PASSES && fabs(bent) > STRAIGHT * speed * speed; pass++) {
            const double product = second_order_gradient(s, f->y1, speed, u, &row);
            for (int i = 0; i < s->n && product > 0.0; i++)
                u[i] -= bent / product * row.du[i];
            bent = bend(s, f->y1, u, &row);
        }
        done = fabs(bent) <= STRAIGHT * speed * speed;
    }
    give_back(s->arena, mark);
    return done;
}

/* The accelerations f->dy, brought to what they are in the limit along the velocities: bend(u) stays 0 along the motion
 * (eq. 8.5). */
static enum outcome limit_along_branch(struct phase *f)
{
    struct system *s = f->s;
    const int n = s->n;
    const struct mark mark = s->arena->top;
    struct lost_row row;
    double *u = f->y + n, *u_dot = f->dy + n, *q = TAKE(s->arena, double, n);
    const enum outcome outcome = take_lost_row(s, &row) ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    const double speed = fastest(s, u), time = BRANCH_STEP / speed;
    for (int number = 0; !outcome && left_null_vector(s, f->y, number, row.lambda); number++) {
        const double product = second_order_gradient(s, f->y, speed, u, &row);
        double wrong = 0.0;
        for (int side = -1; side <= 1; side += 2) {
            for (int i = 0; i < n; i++)
                q[i] = f->y[i] + side * time * u[i];
            wrong += side * bend(s, q, u, &row) / (2.0 * time);
        }
        for (int i = 0; i < n; i++)
            wrong += row.gradient[i] * u_dot[i];
        for (int i = 0; i < n && product > 0.0; i++)
            u_dot[i] -= wrong / product * row.du[i];
    }
    give_back(s->arena, mark);
    return outcome;
}

enum outcome leave_singularity(struct phase *f)
{
    struct system *s = f->s;
    const size_t n = s->n;
    int leaves = 0;
    contact_rates(s, f->y, f->y + n, f->rates);
    for (int c = 0; c < s->model->contacts; c++)
        leaves |= f->rates[c] > rest_velocity(f, c);
    if (!leaves || f->t != f->at.flat)
        return evaluate_derivative(f);
    memcpy(f->y1, f->y, (size_t)s->size * sizeof *f->y);
    enum outcome outcome = OUTCOME_DONE;
    if (project_to_tangent_cone(f) && energy(f, f->y1) <= energy(f, f->y)) { /* once more: contacts have come to rest */
        int count = 0;
        contact_gaps(s, f->y, f->gaps);
        for (int c = 0; c < s->model->contacts; c++)
            if (f->gaps[c] <= SHUT * s->extent[c])
                f->set[count++] = c;
        outcome = commit_snap(f, count);
    }
    outcome = outcome ? outcome : evaluate_derivative(f);
    return outcome ? outcome : limit_along_branch(f);
}

/* Hold those of the contacts f->set that are at rest. */
static void hold_resting(struct phase *f, int count)
{
    struct active_set *h = f->s->active;
    int held = 0;
    contact_rates(f->s, f->y1, f->y1 + f->s->n, f->rates);
    for (int i = 0; i < count; i++)
        if (fabs(f->rates[f->set[i]]) <= rest_velocity(f, f->set[i])) {
            note_rest(f, f->set[i], f->rates[f->set[i]]);
            h->mode[held] = FRICTIONLESS;
            h->set[held++] = f->set[i];
        }
    activate(h, held, h->set, h->mode);
}

/* How many of the contacts f->set move too fast to stay within what is unknown, falling or not */
static int too_fast(struct phase *f, int count, double gap_uncertainty, double fall, int *down)
{
    const struct system *s = f->s;
    int found = 0;
    *down = 0;
    contact_rates(s, f->y1, f->y1 + s->n, f->rates);
    for (int i = 0; i < count; i++) {
        const double rate = f->rates[f->set[i]];
        const int quick = rate * rate > 2.0 * fall * gap_uncertainty * s->extent[f->set[i]];
        found += quick;
        *down += quick && rate < 0.0;
    }
    return found;
}

/* Give y1 velocities with which it may be gone on from: whether there are such. The contacts f->set move as contacts at the end
 * of their bounces do, too slowly to leave what is unknown; or all others fall into their grounds, along velocities that lead
 * there. Where that would take more than an impact may that no contact has, some fall as they are, and what does not lead
 * there is lost in the impact that follows. */
static int finds_way_on(struct phase *f, int count, double gap_uncertainty)
{
    struct system *s = f->s;
    int down;
    activate(s->active, 0, NULL, NULL);
    if (project_velocity(s, f->y1, f->y1 + s->n))
        return 0;
    const double fall = falling(f);
    if (!too_fast(f, count, gap_uncertainty, fall, &down))
        return keeps_energy(f);
    hold_resting(f, count);
    const int straight = project_to_tangent_cone(f);
    activate(s->active, 0, NULL, NULL);
    if (straight && too_fast(f, count, gap_uncertainty, fall, &down) == down && keeps_energy(f))
        return 1;
    memcpy(f->y1 + s->n, f->y + s->n, s->n * sizeof *f->y);
    if (project_velocity(s, f->y1, f->y1 + s->n))
        return 0;
    return too_fast(f, count, gap_uncertainty, fall, &down) && down && keeps_energy(f);
}

/* Take all velocities from y1, if it is to stay where it has been put. */
static int stays(struct phase *f, int count, double gap_uncertainty)
{
    (void)count, (void)gap_uncertainty;
    memset(f->y1 + f->s->n, 0, f->s->n * sizeof *f->y1);
    return 1;
}

/* Close the contacts with gaps below `gap_uncertainty` if that makes closure rows fewer than `rank`, with the velocities that goes_on gives; whether
 * it was done. */
static int snap_below(struct phase *f, double gap_uncertainty, double miss, int rank,
                      int (*goes_on)(struct phase *f, int count, double gap_uncertainty), double *closure,
                      enum outcome *outcome)
{
    struct system *s = f->s;
    struct active_set *h = s->active;
    const size_t all = s->model->contacts;
    const int count = uncertain_contacts(f, gap_uncertainty), held = h->count;
    if (!count)
        return 0;
    const struct mark mark = s->arena->top;
    int *set = TAKE(s->arena, int, all), done = 0;
    signed char *smooth = TAKE_ZEROS(s->arena, signed char, all), *mode = TAKE(s->arena, signed char, all);
    *outcome = OUTCOME_NO_MEMORY;
    if (!s->arena->ran_out) {
        memcpy(set, h->set, held * sizeof *set);
        memcpy(mode, h->mode, held);
        activate(h, count, f->set, smooth); /* FRICTIONLESS */
        done = closes_contacts(f, count, miss, rank, closure) && goes_on(f, count, gap_uncertainty);
        activate(h, held, set, mode);
        *outcome = done ? commit_snap(f, count) : OUTCOME_DONE;
    }
    if (done) {
        f->at.gap_uncertainty = gap_uncertainty;
        f->at.flat = f->t;
    }
    give_back(s->arena, mark);
    return done;
}

enum outcome snap_to_singularity(struct phase *f, int stuck, int *closed)
{
    struct system *s = f->s;
    const int rows = s->model->rows + s->model->drives;
    const double before = f->at.gap_uncertainty;
    enum outcome outcome = OUTCOME_DONE;
    double sigma;
    *closed = 0;
    f->at.gap_uncertainty = 0.0;
    if (!s->model->rows)
        return outcome;
    const struct mark mark = s->arena->top;
    double *closure = TAKE(s->arena, double, s->model->rows);
    if (s->arena->ran_out) {
        outcome = OUTCOME_NO_MEMORY;
        goto end;
    }
    const double miss = closure_miss(f, closure);
    if (!uncertain_contacts(f, unknown(0.0, miss))) {
        if (before > 0.0 && row_rank(s, f->y, &sigma) < rows) { /* where it was put, it still is */
            f->at.gap_uncertainty = before;
            f->at.flat = f->t;
        }
        goto end;
    }
    const int rank = row_rank(s, f->y, &sigma);
    const double gap_uncertainty = unknown(sigma, miss);
    for (int wider = 0; sigma <= TURNS * s->model->links * gap_uncertainty && wider <= stuck && !*closed && !outcome;
         wider++)
        *closed = snap_below(f, (wider ? WIDER : 1.0) * gap_uncertainty, miss, rank, finds_way_on, closure, &outcome);
    if (!*closed && rank < rows && !outcome) /* a row that is left out already: how near, is not known either */
        *closed = snap_below(f, MARGIN * RANK_TOLERANCE, miss, rank + 1, finds_way_on, closure, &outcome);
end:
    give_back(s->arena, mark);
    return outcome;
}

enum outcome lay_flat(struct phase *f)
{
    struct system *s = f->s;
    double sigma;
    enum outcome outcome = OUTCOME_DONE;
    if (!s->model->rows || fastest(s, f->y + s->n) * s->time > CRAWL)
        return outcome;
    const struct mark mark = s->arena->top;
    double *closure = TAKE(s->arena, double, s->model->rows);
    if (s->arena->ran_out)
        outcome = OUTCOME_NO_MEMORY;
    else {
        const double miss = closure_miss(f, closure);
        const int rank = row_rank(s, f->y, &sigma);
        if (sigma <= TURNS * s->model->links * NO_ACCELERATION)
            snap_below(f, NO_ACCELERATION, miss, rank, stays, closure, &outcome);
    }
    give_back(s->arena, mark);
    return outcome;
}
