/* The Jacobian of the accelerations by q and u, from the generated derivatives (docs/theory, eqs. 11.3 and 11.6).
 *
 * With contacts held, forces p along d = N^T, of what slides N^T - mu sign(slip) T^T, keep their rows R u_dot + dR/dt u zero. What
 * accelerations change by is what they change by with the forces held, in value and along with their places, and what follows from
 * the changes of the forces that keep the rows zero: W dp = -(R du_dot + dR u_dot + d(dR/dt u)), W = R Y, Y what unit forces give. */
#include "motion/jacobian.h"

#include <string.h>

#include "algebra/elimination.h"
#include "base/tolerances.h"
#include "constraints/contact_forces.h"
#include "model/contacts.h"
#include "model/inputs.h"
#include "motion/tangent.h"

/* A state, its motion, and unit directions: as many blocks in q as in u, those in u behind */
struct state {
    double t;
    const double *q, *u;
    double *u_dot, *lambda; /* [n], [rows] of all that acts, held contacts too */
    int blocks;             /* in each of q and u */
    double *units;          /* [blocks][n][lanes] */
    double *tangents;       /* [2 blocks][n + rows][lanes] */
};

static int blocks_of(const struct ccgen_model *m)
{
    return (m->nu + m->derivatives->lanes - 1) / m->derivatives->lanes;
}

size_t jacobian_scratch(const struct ccgen_model *m)
{
    if (!m->derivatives)
        return 0;
    const size_t n = m->nu, lanes = m->derivatives->lanes, size = blocks_of(m) * lanes, c = 2 * (size_t)m->contacts;
    const size_t held = m->contacts ? size * 2 * (n + m->rows) + lanes * (m->constants + 2 * n + 4 * c) : 0;
    return size * (n + 4 * (n + m->rows)) + held + c * (2 * n + 3 * c + 2) + 8 * (n + m->rows);
}

/* Whether the generated derivatives are those of the motion: not with what the model knows nothing of, as a controller or added damping */
static int described(const struct system *s)
{
    return s->model->derivatives && !s->refine && s->baumgarte == 0.0 &&
           (!s->input_source || s->input_source == input_from_table);
}

/* Generalized forces f[n] of the forces of the held contacts, their friction included; push[2 contacts] takes them by contact. */
static void held_forces(const struct system *s, const double *q, double *push, double *more, double *f)
{
    const struct ccgen_model *m = s->model;
    const struct active_set *h = s->active;
    double *slipping = push + m->contacts;
    for (int i = 0; i < h->rows; i++) {
        const int contact = h->set[h->of[i]];
        if (i >= h->count)
            slipping[contact] += h->force[i];
        else {
            push[contact] += lever_of(s, contact) * h->force[i];
            if (against(h->mode[i]))
                slipping[contact] -= against(h->mode[i]) * s->friction[contact] * h->force[i];
        }
    }
    m->contact_impulse(s->k, q, push, f);
    if (!s->friction)
        return;
    m->slip_impulse(s->k, q, slipping, more);
    for (int i = 0; i < s->n; i++)
        f[i] += more[i];
}

/* u_dot and lambda of the motion, and push[2 contacts]; 0, or 1 where pivots vanish or memory runs out */
static int find_motion(struct system *s, const struct state *at, double *push)
{
    const struct ccgen_model *m = s->model;
    s->evaluations++;
    if (m->acceleration(s->k, at->q, at->u, at->t, s->inputs, at->u_dot, at->lambda))
        return 1;
    if (!active_count(s))
        return 0;
    const struct mark mark = s->arena->top;
    double *f = TAKE(s->arena, double, s->n), *du = TAKE(s->arena, double, s->n);
    double *none = TAKE_ZEROS(s->arena, double, m->rows), *Lambda = TAKE(s->arena, double, m->rows);
    int wrong = s->arena->ran_out || add_contact_accelerations(s, at->q, at->u, at->u_dot);
    if (!wrong) {
        held_forces(s, at->q, push, du, f);
        wrong = m->impulse(s->k, at->q, f, none, du, Lambda);
    }
    for (int i = 0; i < m->rows && !wrong; i++)
        at->lambda[i] += Lambda[i];
    give_back(s->arena, mark);
    return wrong;
}

/* What is worked out once for all directions of the held contacts, `rows` of them */
struct held {
    int rows;
    double *push;          /* [2 contacts] */
    double *R;             /* [rows][n] */
    double *Y;             /* [rows][n] */
    double *inverse;       /* [rows][rows] of W */
    double *none;          /* [constants][lanes] zeros, */
    double *still;         /* [n or contacts][lanes] and zeros */
    double *rates, *slips; /* [contacts][lanes] that change, */
    double *part;          /* [n or contacts][lanes] and a part of it */
    double *missed;        /* [rows] */
};

static int take_held(struct system *s, struct held *h)
{
    const struct ccgen_model *m = s->model;
    const size_t n = s->n, k = active_rows(s, 1), lanes = m->derivatives->lanes, c = m->contacts;
    struct arena *arena = s->arena;
    h->rows = (int)k;
    h->R = TAKE(arena, double, (k * n));
    h->Y = TAKE(arena, double, (k * n));
    h->inverse = TAKE(arena, double, (k * k));
    h->none = TAKE_ZEROS(arena, double, (m->constants * lanes));
    h->still = TAKE_ZEROS(arena, double, ((n > c ? n : c) * lanes));
    h->rates = TAKE(arena, double, (c * lanes));
    h->slips = TAKE(arena, double, (c * lanes));
    h->part = TAKE(arena, double, ((n > c ? n : c) * lanes));
    h->missed = TAKE(arena, double, k);
    return arena->ran_out;
}

/* R, Y and the inverse of W; 0, or 1 where rows depend on each other or memory runs out */
static int find_responses(struct system *s, const double *q, struct held *h)
{
    const struct ccgen_model *m = s->model;
    const struct active_set *active = s->active;
    const size_t n = s->n, width = width_of(s), c = m->contacts;
    const int k = h->rows;
    const struct mark mark = s->arena->top;
    double *units = TAKE_ZEROS(s->arena, double, (k * width)), *answers = TAKE(s->arena, double, (k * width));
    double *push = TAKE_ZEROS(s->arena, double, c), *W = TAKE(s->arena, double, (2 * k * k));
    double *copy = W ? W + k * k : NULL, *x = TAKE(s->arena, double, k);
    int wrong = s->arena->ran_out;
    for (int j = 0; j < k && !wrong; j++) {
        const int i = active->of[j], contact = active->set[i];
        active_row(s, q, j, push, h->R + j * n);
        units[j * width + contact + (j < active->count ? 0 : c)] = j < active->count ? lever_of(s, contact) : 1.0;
        if (j < active->count && against(active->mode[i]))
            units[j * width + c + contact] = -against(active->mode[i]) * s->friction[contact];
    }
    wrong = wrong || m->contact_response(s->k, q, k, units, h->Y, answers);
    for (int i = 0; i < k && !wrong; i++)
        for (int j = 0; j < k; j++) {
            W[i * k + j] = 0.0;
            for (size_t l = 0; l < n; l++)
                W[i * k + j] += h->R[i * n + l] * h->Y[j * n + l];
        }
    for (int j = 0; j < k && !wrong; j++) {
        memcpy(copy, W, (size_t)k * k * sizeof *W);
        for (int i = 0; i < k; i++)
            x[i] = i == j;
        wrong = !eliminate(k, copy, x, CONTACT_PIVOT);
        for (int i = 0; i < k; i++)
            h->inverse[i * k + j] = x[i];
    }
    give_back(s->arena, mark);
    return wrong;
}

/* The tangents[size][lanes] of a function by name along one block, added to what is there; those that vanish are none. */
static void add_tangent(const struct ccgen_model *m, const char *name, const struct ccgen_arguments *at,
                        const struct ccgen_arguments *by, double *part, double *tangents)
{
    const struct ccgen_named_tangent *function = find_tangent(m, name);
    if (!function)
        return;
    function->function(at, by, 1, part);
    for (int i = 0; i < function->outputs * m->derivatives->lanes; i++)
        tangents[i] += part[i];
}

/* Tangents of the accelerations with the forces held in value, which change with their places: added to those in flight. */
static enum outcome add_moved_forces(struct system *s, const struct state *at, const struct held *h)
{
    const struct ccgen_model *m = s->model;
    const size_t n = s->n, lanes = m->derivatives->lanes, every = (n + m->rows) * lanes;
    const struct mark mark = s->arena->top;
    double *right = TAKE_ZEROS(s->arena, double, (at->blocks * every));
    double *found = TAKE(s->arena, double, (at->blocks * every));
    enum outcome outcome = s->arena->ran_out ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    for (int b = 0; b < at->blocks && !outcome; b++) {
        struct ccgen_arguments here = {.k = s->k, .q = at->q, .P = h->push};
        const struct ccgen_arguments by = {.k = h->none, .q = at->units + b * n * lanes, .P = h->still};
        add_tangent(m, "contact_impulse", &here, &by, h->part, right + b * every);
        here.P = h->push + m->contacts;
        if (s->friction)
            add_tangent(m, "slip_impulse", &here, &by, h->part, right + b * every);
    }
    outcome = outcome ? outcome : impulse_tangents(s, at->q, at->blocks, right, found);
    for (size_t i = 0; i < at->blocks * every && !outcome; i++)
        at->tangents[i] += found[i];
    give_back(s->arena, mark);
    return outcome;
}

/* What the rates of all contacts change by along a block of directions, accelerations held */
static void change_rates(const struct system *s, const struct state *at, int block, const struct held *h)
{
    const struct ccgen_model *m = s->model;
    const size_t lanes = m->derivatives->lanes, every = s->n * lanes, size = m->contacts * lanes * sizeof *h->rates;
    const int in_q = block < at->blocks;
    const double *unit = at->units + (in_q ? block : block - at->blocks) * every;
    const struct ccgen_arguments moving = {.k = s->k, .q = at->q, .u = at->u};
    const struct ccgen_arguments accelerated = {.k = s->k, .q = at->q, .u = at->u_dot};
    const struct ccgen_arguments by = {.k = h->none, .q = in_q ? unit : h->still, .u = in_q ? h->still : unit};
    memset(h->rates, 0, size);
    memset(h->slips, 0, size);
    add_tangent(m, "gap_bias", &moving, &by, h->part, h->rates);
    if (in_q)
        add_tangent(m, "gap_rates", &accelerated, &by, h->part, h->rates);
    if (h->rows == s->active->count)
        return;
    add_tangent(m, "slip_bias", &moving, &by, h->part, h->slips);
    if (in_q)
        add_tangent(m, "slips", &accelerated, &by, h->part, h->slips);
}

/* What the changes of the forces add along a block of directions */
static void add_changed_forces(const struct system *s, const struct state *at, int block, const struct held *h)
{
    const struct ccgen_model *m = s->model;
    const struct active_set *active = s->active;
    const size_t n = s->n, lanes = m->derivatives->lanes;
    double *tangents = at->tangents + block * (n + m->rows) * lanes;
    change_rates(s, at, block, h);
    for (size_t l = 0; l < lanes; l++) {
        for (int i = 0; i < h->rows; i++) {
            const int contact = active->set[active->of[i]];
            double sum = i < active->count ? lever_of(s, contact) * h->rates[contact * lanes + l]
                                           : h->slips[contact * lanes + l];
            for (size_t j = 0; j < n; j++)
                sum += h->R[i * n + j] * tangents[j * lanes + l];
            h->missed[i] = sum;
        }
        for (int i = 0; i < h->rows; i++) {
            double force = 0.0;
            for (int j = 0; j < h->rows; j++)
                force -= h->inverse[i * h->rows + j] * h->missed[j];
            for (size_t j = 0; j < n; j++)
                tangents[j * lanes + l] += force * h->Y[i * n + j];
        }
    }
}

static enum outcome add_contacts(struct system *s, const struct state *at, double *push, int *known)
{
    const struct mark mark = s->arena->top;
    struct held h = {.push = push};
    enum outcome outcome = take_held(s, &h) ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    *known = !outcome && !find_responses(s, at->q, &h);
    if (*known)
        outcome = add_moved_forces(s, at, &h);
    for (int b = 0; b < 2 * at->blocks && *known && !outcome; b++)
        add_changed_forces(s, at, b, &h);
    give_back(s->arena, mark);
    return outcome;
}

static enum outcome find_tangents(struct system *s, const struct state *at, double *push, int *known)
{
    const int n = s->n, lanes = s->model->derivatives->lanes;
    const struct directions along = {.by = {.q = at->units, .u = at->units},
                                     .blocks = 2 * at->blocks,
                                     .first = {[MOVES_Q] = 0, [MOVES_U] = at->blocks},
                                     .count = {[MOVES_Q] = at->blocks, [MOVES_U] = at->blocks}};
    double miss;
    for (int i = 0; i < n; i++)
        at->units[((size_t)(i / lanes) * n + i) * lanes + i % lanes] = 1.0;
    const enum outcome outcome =
        acceleration_tangents(s, at->t, at->q, at->u, at->u_dot, at->lambda, &along, at->tangents, &miss);
    *known = miss < 0.0;
    return !outcome && *known && active_count(s) ? add_contacts(s, at, push, known) : outcome;
}

enum outcome acceleration_jacobian(struct system *s, double t, const double *q, const double *u, double *by_q,
                                   double *by_u, int *known)
{
    const struct ccgen_model *m = s->model;
    *known = described(s);
    if (!*known)
        return OUTCOME_DONE;
    if (interrupted(s->interruption, (long)s->n * s->n))
        return OUTCOME_INTERRUPTED;
    const size_t n = s->n, lanes = m->derivatives->lanes, blocks = blocks_of(m), every = (n + m->rows) * lanes;
    const struct mark mark = s->arena->top;
    const struct state at = {
        .t = t,
        .q = q,
        .u = u,
        .u_dot = TAKE(s->arena, double, n),
        .lambda = TAKE(s->arena, double, m->rows),
        .blocks = (int)blocks,
        .units = TAKE_ZEROS(s->arena, double, (blocks * n * lanes)),
        .tangents = TAKE(s->arena, double, (2 * blocks * every)),
    };
    double *push = TAKE_ZEROS(s->arena, double, (2 * (size_t)m->contacts));
    enum outcome outcome = s->arena->ran_out ? OUTCOME_NO_MEMORY : supply_inputs(s, t, q, u);
    if (!outcome && find_motion(s, &at, push))
        *known = 0;
    if (!outcome && *known)
        outcome = find_tangents(s, &at, push, known);
    for (size_t j = 0; j < n && *known && !outcome; j++) {
        const double *column = at.tangents + j / lanes * every + j % lanes;
        for (size_t i = 0; i < n; i++) {
            by_q[i * n + j] = column[i * lanes];
            by_u[i * n + j] = column[blocks * every + i * lanes];
        }
    }
    give_back(s->arena, mark);
    return outcome;
}
