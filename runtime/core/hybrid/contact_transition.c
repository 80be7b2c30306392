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
 * 2 v / (a (1 - e)), eq. 5.7 with kappa = e.
 */
#include "hybrid/contact_transition.h"

#include <math.h>
#include <string.h>

#include "algebra/power_of_two.h"
#include "base/tolerances.h"
#include "complementarity/complementarity.h"
#include "complementarity/friction.h"
#include "complementarity/sharing.h"
#include "constraints/branch.h"
#include "constraints/delassus.h"
#include "constraints/mobility.h"
#include "constraints/onto_branch.h"
#include "constraints/twins.h"
#include "hybrid/activation.h"
#include "hybrid/coming_to_rest.h"
#include "hybrid/decision.h"
#include "motion/projection.h"
#include "model/contacts.h"

/* Bring W[n][n] and b[n] to about 1 by powers of two, without rounding; what the forces are then to be multiplied with. */
static double normalise(int n, double *W, double *b)
{
    double largest = 0.0, fastest = 0.0;
    for (int i = 0; i < n; i++) {
        largest = fmax(largest, W[i * (n + 1)]);
        fastest = fmax(fastest, fabs(b[i]));
    }
    const double w = power_of_two(largest), scale = power_of_two(fastest);
    multiply(n * n, 1.0 / w, W);
    multiply(n, 1.0 / scale, b);
    return scale / w;
}

/* Forces x at m rough contacts, from the parts of the problem that are theirs; nonzero as `solve_friction` says. Where there are none,
 * those of contacts that give way a little, if they are of the size of what they come from: contacts that press each other with what moves next
 * to nothing have such, and where friction jams they are as large as the ground is stiff. */
static int solve_rough(struct arena *arena, struct decision *d, int m)
{
    struct part *p = &d->part;
    struct friction_problem problem = {
        .n = m, .W = p->W, .bn = p->b, .bt = p->b + m, .mu = p->mu, .mode = p->mode, .arena = arena};
    const struct mark mark = arena->top;
    int wrong = prepare_friction(&problem) ? 2 : solve_friction(&problem, p->x, p->x + m);
    for (double part = COMPLIANCE, given = 0.0; wrong && !arena->ran_out && part <= SOFTEST; part *= SOFTER) {
        give_way(2 * m, part - given, p->W);
        given = part;
        wrong = solve_friction(&problem, p->x, p->x + m);
        if (!wrong && !(part * loaded(&problem, p->x) <= GIVES_WAY * approaching(&problem)))
            wrong = 1;
    }
    give_back(arena, mark);
    return wrong;
}

/* Of the forces x at m contacts, from the parts of the problem that are theirs, those of least norm that do the same: what opens has none, and what begins to slide is
 * at its limit. Where rounding keeps the search from its end, forces stay that obey the law as well. */
static enum outcome share(struct arena *arena, struct decision *d, int m, double *x)
{
    struct part *p = &d->part;
    const int width = d->all > d->count ? 2 * m : m;
    const struct mark mark = arena->top;
    signed char *side = TAKE_ZEROS(arena, signed char, m);
    char *leaves = TAKE_ZEROS(arena, char, m);
    double scale = 0.0;
    for (int i = 0; i < width; i++)
        scale = fmax(scale, fabs(p->b[i]));
    for (int i = 0; i < width && !arena->ran_out; i++) {
        double z = p->b[i];
        for (int j = 0; j < width; j++)
            z += p->W[(size_t)i * width + j] * x[j];
        if (i < m) {
            leaves[i] = z > PRESSED * scale;
            side[i] = width > m ? p->mode[i] : 0;
        } else if (!side[i - m] && fabs(z) > PRESSED * scale)
            side[i - m] = z > 0.0 ? 1 : -1;
    }
    const struct shared problem = {.n = m,
                                   .rows = width,
                                   .W = p->W,
                                   .mu = p->mu,
                                   .side = side,
                                   .leaves = leaves,
                                   .beyond = AS_GIVEN,
                                   .arena = arena};
    const enum outcome outcome = arena->ran_out ? OUTCOME_NO_MEMORY : share_forces(&problem, x);
    give_back(arena, mark);
    return outcome == OUTCOME_REPEATS ? OUTCOME_DONE : outcome;
}

/* Solve for the contacts that take part, but without `except`: P[all]. */
static enum outcome solve(const struct phase *f, struct decision *d, int except, double *P)
{
    struct arena *arena = f->s->arena;
    const int n = d->count, rough = d->all > n;
    double *W = d->part.W, *b = d->part.b, *mu = d->part.mu, *x = d->part.x;
    signed char *mode = d->part.mode;
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
            mode[k] = d->mode[i];
        }
        b[k++] = d->b[i];
    }
    memset(P, 0, d->all * sizeof *P);
    const double unit = normalise(width, W, b);
    const int wrong = rough ? solve_rough(arena, d, m) : solve_complementarity(arena, m, W, b, x);
    if (wrong)
        return rough && wrong == 1 ? OUTCOME_JAMMED
               : rough || f->s->model->drives
                   ? OUTCOME_REPEATS
                   : OUTCOME_INEXACT; /* smooth contacts have forces (docs/theory, section 5.2) */
    if (except < 0 && share(arena, d, m, x))
        return OUTCOME_NO_MEMORY;
    k = 0;
    for (int i = 0; i < d->all; i++)
        if (d->in[i % n] && i % n != except)
            P[i] = unit * x[k++];
    return OUTCOME_DONE;
}

/* A contact of those that have no solution by themselves, whatever else is closed */
static int find_at_fault(const struct phase *f, struct decision *d)
{
    struct arena *arena = f->s->arena;
    const struct mark mark = arena->top;
    const int n = d->count;
    char *there = TAKE(arena, char, n), *holds = TAKE(arena, char, d->all), *taken = TAKE_ZEROS(arena, char, d->all);
    int *row = TAKE(arena, int, d->all), at_fault = -1;
    for (int a = 0; a < d->all && !arena->ran_out; a++)
        holds[a] = there[a % n] = d->in[a % n];
    for (int i = 0; i < n && at_fault < 0 && !arena->ran_out; i++) {
        if (!there[i] || taken[i])
            continue;
        memset(d->in, 0, n);
        for (int k = rows_that_move_each_other(n, d->all, holds, d->W, i, taken, row) - 1; k >= 0; k--)
            d->in[row[k] % n] = 1;
        at_fault = solve(f, d, -1, d->trial) ? d->contact[i] : -1;
        memcpy(d->in, there, n);
    }
    give_back(arena, mark);
    return at_fault;
}

/* Take out contacts that still bounce, until all that push have come to rest. */
static enum outcome release_bouncing(const struct phase *f, struct decision *d, int resting)
{
    for (int i = 0; i <= d->count; i++) {
        if (interrupted(f->s->interruption, 0))
            return OUTCOME_INTERRUPTED;
        enum outcome outcome = solve(f, d, -1, d->P);
        if (outcome) {
            f->run->contact = find_at_fault(f, d);
            return outcome;
        }
        int bouncing = -1;
        for (int j = 0; j < d->count && bouncing < 0; j++) {
            const double speed = f->rates[d->contact[j]], e = f->s->restitution[d->contact[j]];
            if (!pushes(d, j) || speed <= rest_velocity(f, d->contact[j]) ||
                ((resting == ALL_REST || resting == d->contact[j]) && may_rest(f, d->contact[j], speed)))
                continue;
            if ((outcome = solve(f, d, j, d->trial)))
                return outcome;
            const double fall = -gap_acceleration(d, j, d->trial) / d->enlarged;
            if (!(2.0 * speed <= REST_TIME * fmax(f->s->time, fabs(f->t)) * fall * (1.0 - e)))
                bouncing = j;
        }
        if (bouncing < 0)
            return OUTCOME_DONE;
        d->in[bouncing] = 0;
    }
    return OUTCOME_DONE;
}

/* Let go of contacts that slide and could as well leave as stay, friction growing faster than what it resists (Painleve): they leave, as from a
 * ground that gives way a little and is not pressed (docs/theory, section 5.11). How many there are. */
static int choose_to_leave(struct decision *d)
{
    int count = 0;
    for (int i = 0; d->all > d->count && i < d->count; i++) {
        const double *row = d->W + i * d->all, own = row[i] - d->mode[i] * d->mu[d->contact[i]] * row[d->count + i];
        const int leaves = d->in[i] && d->mode[i] && own < 0.0 && d->b[i] > PRESSED * d->scale;
        d->in[i] = (char)(d->in[i] && !leaves);
        count += leaves;
    }
    return count;
}

/* Leave out contacts whose gaps no motion changes, as of a body that driven joints hold where it touches a ground: forces there do nothing, and
 * have no solution. One that neither opens nor closes stands. */
static enum outcome leave_out_immovable(struct phase *f, struct decision *d)
{
    struct arena *arena = f->s->arena;
    const struct mark mark = arena->top;
    char *moves = TAKE(arena, char, d->count);
    const enum outcome outcome =
        arena->ran_out ? OUTCOME_NO_MEMORY : movable_contacts(f->s, f->y, d->count, d->contact, moves);
    const double usual = f->s->length / (f->s->time * f->s->time);
    for (int i = 0; !outcome && i < d->count; i++)
        if (!moves[i]) {
            const int c = d->contact[i];
            d->in[i] = 0;
            d->stands[i] = fabs(d->b[i]) <= PRESSED * fmax(d->scale, usual) && f->gaps[c] <= ADRIFT * f->s->extent[c];
        }
    give_back(arena, mark);
    return outcome;
}

/* Whether row i of W is row j, as far as its entries tell */
static int is_one_row(const struct decision *d, int i, int j)
{
    const double ii = d->W[i * (d->all + 1)], jj = d->W[j * (d->all + 1)], ij = d->W[i * d->all + j];
    return ii + jj - 2.0 * ij <= IMPLIED_SHARE * ii;
}

/* Whether candidate i is a twin of j: 1 where j bears, -1 where i does, 0 where they are none. W tells most that are not. Of rough ones that slide
 * both know the direction, or none does. */
static int twins(const struct phase *f, const struct decision *d, int i, int j)
{
    const int a = d->contact[i], b = d->contact[j], rough = d->all > d->count && (d->mu[a] > 0.0 || d->mu[b] > 0.0);
    if (!is_one_row(d, i, j) || (rough && d->mode[i] != d->mode[j]))
        return 0;
    return twins_at(f->s, f->y, a, b);
}

/* Of contacts that touch alike only one is asked, the one that bears. What the other would do instead, no force tells. */
static void pair_twins(const struct phase *f, struct decision *d)
{
    for (int i = 0; i < d->count; i++)
        for (int j = 0; j < i && d->in[i]; j++) {
            const int which = d->in[j] ? twins(f, d, i, j) : 0, carried = which > 0 ? i : j, bears = i + j - carried;
            if (!which)
                continue;
            for (int k = 0; k < i; k++)
                d->twin[k] = d->twin[k] == carried ? bears : d->twin[k];
            d->twin[carried] = bears;
            d->in[carried] = 0;
        }
}

/* The state put back, along the branch of the motion where one is followed: on the closure as it is rows would be left out, and as the next step begins
 * other contacts would get back what they have lost. */
static enum outcome put_back(struct phase *f)
{
    struct system *s = f->s;
    const size_t n = s->n;
    const struct mark mark = s->arena->top;
    double *there = TAKE(s->arena, double, 2 * n);
    enum outcome outcome = s->arena->ran_out ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    if (!outcome && s->branch && follows_at(s, f->y)) {
        memcpy(there, f->y, 2 * n * sizeof *there);
        outcome = put_onto_branch(s, there, there + n);
        if (!outcome)
            memcpy(f->y, there, 2 * n * sizeof *there);
        if (!outcome || outcome == OUTCOME_INTERRUPTED || outcome == OUTCOME_NO_MEMORY)
            goto end;
        outcome = project_position(s, f->y);
    }
    outcome = outcome ? outcome : project_velocity(s, f->y, f->y + n);
end:
    give_back(s->arena, mark);
    return outcome;
}

/* Bring the gaps of what is held to rest, and the sliding of what was asked whether it slides: that is rounding, and may be
 * against the direction in which it will slide. Other closed contacts that this drives into their grounds come to rest with
 * them: they would strike and undo it. */
static enum outcome project_contact_velocities(struct phase *f, struct decision *d, int resting, const char *goes_on,
                                               const struct before_rest *before)
{
    struct active_set *h = f->s->active;
    const int count = h->count;
    struct arena *arena = f->s->arena;
    const struct mark mark = arena->top;
    signed char *mode = TAKE(arena, signed char, count);
    enum outcome outcome = OUTCOME_NO_MEMORY;
    if (arena->ran_out)
        goto end;
    memcpy(mode, h->mode, count);
    for (int i = 0, k = 0; f->s->friction && i < d->count; i++)
        if (stays(d, i)) {
            h->mode[k] = goes_on[i] ? mode[k] : STICK;
            k++;
        }
    activate(h, count, h->set, h->mode);
    outcome = put_back(f);
    contact_rates(f->s, f->y, f->y + f->s->n, f->rates);
    const int rest = resting == ALL_REST && !another_opens(f, before);
    for (int i = 0; rest && i < d->count; i++)
        if (!stays(d, i) && f->rates[d->contact[i]] < 0.0) {
            h->mode[h->count] = FRICTIONLESS;
            h->set[h->count++] = d->contact[i];
        }
    const int all = h->count;
    if (!outcome && all > count) {
        activate(h, all, h->set, h->mode);
        outcome = put_back(f);
        contact_rates(f->s, f->y, f->y + f->s->n, f->rates);
    }
    const double speed = fastest(f->s, f->y + f->s->n);
    for (int k = count; k < all && !outcome; k++) { /* what rows that all but depend leave */
        const int c = h->set[k];
        if (f->rates[c] < -ROUNDED_RATE * speed * f->s->extent[c] && f->rates[c] >= -rest_velocity(f, c) &&
            h->closed[c] != CARRIED) {
            h->closed[c] = CARRIED;
            h->implied++;
        }
    }
    activate(h, count, h->set, mode);
end:
    give_back(arena, mark);
    return outcome;
}

/* Which contacts are held from now on, the state being left where it is. */
static enum outcome select_contacts(struct phase *f, struct decision *d, struct mode_change loss, int resting)
{
    d->events_crowd = resting == ALL_REST;
    d->loss = loss;
    enum outcome outcome = decide_on_branch(f);
    outcome = outcome ? outcome : gather_candidates(f, d);
    d->chosen = outcome ? 0 : choose_to_leave(d);
    if (!outcome && d->count && f->s->model->drives)
        outcome = leave_out_immovable(f, d);
    if (!outcome)
        pair_twins(f, d);
    if (!outcome && d->count)
        outcome = release_bouncing(f, d, resting);
    return outcome || !d->count ? outcome : activate_selected(f, d, d->loss);
}

/* Whether what was brought to rest has turned the sliding of a contact around, whose direction its friction has */
static int turns_sliding(const struct phase *f, const struct decision *d, double *slips)
{
    const struct system *s = f->s;
    if (!s->friction)
        return 0;
    s->model->slips(s->k, f->y, f->y + s->n, slips);
    for (int i = 0; i < d->count; i++)
        if (stays(d, i) && !d->touches[i] && d->mode[i] * slips[d->contact[i]] < -STILL * s->length / s->time)
            return 1;
    return 0;
}

/* Which candidates go on along their grounds as they are: smooth ones, those of which the sliding was known, and of the others, which are as slow as what may rest, those that slide
 * as has been found. What is brought to rest in a crowd of events is noted with how fast it has moved. */
static void look_what_goes_on(struct phase *f, const struct decision *d, double *slips, char *goes_on)
{
    const struct system *s = f->s;
    const struct active_set *h = s->active;
    if (s->friction)
        s->model->slips(s->k, f->y, f->y + s->n, slips);
    for (int i = 0, k = 0; i < d->count; i++) {
        const int c = d->contact[i];
        if (!stays(d, i))
            continue;
        const int mode = h->mode[k++];
        const int slides = mode == SLIP_FORWARD || mode == SLIP_BACKWARD;
        const double still = STILL * s->length / s->time;
        goes_on[i] = !s->friction || s->friction[c] == 0.0 || d->mode[i] || d->touches[i] ||
                     (slides && against(mode) * slips[c] > still);
        note_rest(f, c, f->rates[c]);
        if (!goes_on[i])
            note_rest(f, c, slips[c]);
    }
}

static enum outcome select_and_project(struct phase *f, struct decision *d, struct mode_change loss, int resting,
                                       double *slips, char *goes_on, const struct before_rest *before)
{
    enum outcome outcome = select_contacts(f, d, loss, resting);
    if (outcome || !f->s->active->count)
        return outcome;
    look_what_goes_on(f, d, slips, goes_on);
    outcome = f->s->branch && follows_at(f->s, f->y) ? OUTCOME_DONE : project_position(f->s, f->y);
    return outcome ? outcome : project_contact_velocities(f, d, resting, goes_on, before);
}

static void deactivate_all(struct active_set *h, size_t contacts)
{
    memset(h->closed, WATCHED, contacts);
    for (size_t c = 0; c < contacts; c++)
        h->twin[c] = -1;
    h->implied = 0;
    h->window = 0.0;
    activate(h, 0, NULL, NULL);
}

enum outcome release_contacts(struct phase *f)
{
    struct active_set *h = f->s->active;
    const size_t c = f->s->model->contacts;
    const struct mark mark = f->s->arena->top;
    signed char *how = TAKE(f->s->arena, signed char, c);
    enum outcome outcome = OUTCOME_NO_MEMORY;
    if (!f->s->arena->ran_out) {
        deactivate_all(h, c);
        memset(h->peak, 0, c * sizeof *h->peak);
        contact_modes(h, (int)c, how);
        outcome = append_modes(&f->run->modes, f->t, (int)c, how) ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    }
    give_back(f->s->arena, mark);
    return outcome;
}

/* Select, and again where that turns sliding around, or where what was held does not come to rest. Every time takes energy; where it does not end, time
 * stepping goes on. */
static enum outcome select_consistently(struct phase *f, struct mode_change loss, int resting, int *chosen)
{
    struct system *s = f->s;
    struct active_set *h = s->active;
    const size_t c = s->model->contacts;
    const struct mark all = s->arena->top;
    signed char *was = TAKE_ZEROS(s->arena, signed char, c);
    struct before_rest before;
    if (!note_before_rest(f, &before))
        contact_modes(h, (int)c, was);
    const struct mark mark = s->arena->top;
    const struct mode_change none = {-1, DETACHES};
    enum outcome outcome = s->arena->ran_out ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    int again = !outcome;
    for (size_t i = 0; again && i <= 3 * c; i++) {
        struct decision d;
        double *slips = TAKE(s->arena, double, c);
        char *goes_on = TAKE_ZEROS(s->arena, char, c);
        again = 0;
        if (take_decision(&d, s)) {
            outcome = OUTCOME_NO_MEMORY;
        } else {
            /* what vanishes is told by those that were held until the event: not by those just found */
            d.moves = before.moves;
            d.opens = before.opens;
            memcpy(d.was, was, c);
            outcome = find_vanishing(f, i ? none : loss, &d.vanishing);
            deactivate_all(h, c);
            outcome = outcome ? outcome : select_and_project(f, &d, loss, resting, slips, goes_on, &before);
            s->branch = NULL;
            outcome = outcome ? outcome : ask_for_less(f, &d, &before, goes_on, &again);
            if (!outcome && h->count && !again)
                again = turns_sliding(f, &d, slips);
            *chosen = d.chosen;
            if (outcome == OUTCOME_JAMMED)
                f->run->contact = d.count ? d.contact[0] : -1;
        }
        give_back(s->arena, mark);
    }
    give_back(s->arena, all);
    return again ? OUTCOME_REPEATS : outcome;
}

enum outcome select_active_set(struct phase *f, struct mode_change loss, int resting)
{
    struct active_set *h = f->s->active;
    struct run *run = f->run;
    const size_t c = f->s->model->contacts;
    const struct mark mark = f->s->arena->top;
    signed char *how = TAKE(f->s->arena, signed char, c);
    enum outcome outcome = OUTCOME_NO_MEMORY;
    int chosen = 0;
    if (!f->s->arena->ran_out) {
        outcome = select_consistently(f, loss, resting, &chosen);
        if (!outcome && !h->count)
            memset(h->peak, 0, c * sizeof *h->peak);
        contact_modes(h, (int)c, how);
        if (!outcome && append_modes(&run->modes, f->t, (int)c, how))
            outcome = OUTCOME_NO_MEMORY;
        if (!outcome && record_state(f))
            outcome = OUTCOME_NO_MEMORY;
        if (!outcome && chosen && !run->choices++)
            run->chosen_at = f->t;
    }
    give_back(f->s->arena, mark);
    return outcome;
}

enum outcome would_activate(struct phase *f, int *strikes)
{
    struct system *s = f->s;
    const struct mode_change none = {-1, DETACHES};
    const struct mark mark = s->arena->top;
    struct decision d;
    enum outcome outcome = OUTCOME_NO_MEMORY;
    *strikes = -1;
    if (!take_decision(&d, f->s)) {
        deactivate_all(s->active, s->model->contacts);
        outcome = select_contacts(f, &d, none, NONE_RESTS);
        s->branch = NULL;
        outcome = !outcome && d.chosen ? OUTCOME_JAMMED : outcome; /* a state has no rule: a run has */
        for (int c = 0, i = 0; c < s->model->contacts && !outcome; c++) {
            const int asked = i < d.count && d.contact[i] == c;
            i += asked;
            if (!asked && f->gaps[c] <= SHUT * s->extent[c] && f->rates[c] < 0.0 &&
                (*strikes < 0 || f->rates[c] < f->rates[*strikes]))
                *strikes = c;
        }
    }
    give_back(s->arena, mark);
    return outcome;
}
