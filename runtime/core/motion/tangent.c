/* Derivatives of accelerations and multipliers (docs/theory, eq. 11.3): M du_dot = A^T dlambda + f, A du_dot = y, where f and y
 * are the tangents of what the equations of motion miss by, u_dot and lambda held. However these were found, that is exact:
 * the implicit function theorem (A. Griewank, A. Walther, Evaluating Derivatives, 2008, section 15). */
#include "motion/tangent.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "base/tolerances.h"
#include "constraints/impulse.h"
#include "model/inputs.h"

const struct ccgen_named_tangent *find_tangent(const struct ccgen_model *m, const char *name)
{
    for (int i = 0; m->derivatives && i < m->derivatives->count; i++)
        if (!strcmp(m->derivatives->tangents[i].name, name))
            return &m->derivatives->tangents[i];
    return NULL;
}

/* Right-hand sides f[n][lanes] and, behind them, y[rows][lanes] of each block, and what the accelerations of driven joints change by */
struct sides {
    double *right;  /* [blocks][n + rows][lanes] */
    double *forced; /* [blocks][n][lanes] accelerations that only driven joints have, or NULL */
};

/* The residual of one argument in the blocks that move it, added to what others have brought to the first `filled` blocks */
static enum outcome add_residual(struct system *s, const struct ccgen_arguments *at, const struct directions *along,
                                 int i, ccgen_tangent *residual, int filled, double *right)
{
    const size_t every = (size_t)(s->n + s->model->rows) * s->model->derivatives->lanes;
    const int first = along->first[i], count = along->count[i];
    double *here = right + first * every;
    if (first >= filled) {
        memset(right + filled * every, 0, (first - filled) * every * sizeof *right);
        residual(at, &along->by, count, here);
        return OUTCOME_DONE;
    }
    const struct mark mark = s->arena->top;
    double *part = TAKE(s->arena, double, (count * every));
    const enum outcome outcome = s->arena->ran_out ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    if (!outcome) {
        if (first + count > filled)
            memset(right + filled * every, 0, (first + count - filled) * every * sizeof *right);
        residual(at, &along->by, count, part);
        for (size_t j = 0; j < count * every; j++)
            here[j] += part[j];
    }
    give_back(s->arena, mark);
    return outcome;
}

/* The sum over the arguments that move */
static enum outcome add_residuals(struct system *s, const struct ccgen_arguments *at, const struct directions *along,
                                  double *right)
{
    const struct ccgen_derivatives *d = s->model->derivatives;
    ccgen_tangent *const residuals[MOVES] = {d->residual_q, d->residual_u, d->residual_k, d->residual_t};
    const size_t every = (size_t)(s->n + s->model->rows) * d->lanes;
    enum outcome outcome = OUTCOME_DONE;
    int filled = 0;
    for (int i = 0; i < MOVES && !outcome; i++)
        if (residuals[i] && along->count[i]) {
            outcome = add_residual(s, at, along, i, residuals[i], filled, right);
            if (along->first[i] + along->count[i] > filled)
                filled = along->first[i] + along->count[i];
        }
    memset(right + filled * every, 0, (along->blocks - filled) * every * sizeof *right);
    return outcome;
}

/* One direction of many: number l of a block */
static void take_lane(const double *from, size_t count, size_t lanes, size_t l, double *to)
{
    for (size_t i = 0; i < count; i++)
        to[i] = from[i * lanes + l];
}

static void put_lane(double *to, size_t count, size_t lanes, size_t l, const double *from)
{
    for (size_t i = 0; i < count; i++)
        to[i * lanes + l] = from[i];
}

/* x[n][lanes] in which driven joints have the relative accelerations relative[drives][lanes], and nothing else moves */
static void drive(const struct ccgen_model *m, size_t lanes, const double *relative, double *x)
{
    for (int pass = 0; pass < m->drives; pass++) /* a joint may be driven against one that is driven */
        for (int d = 0; d < m->drives; d++)
            for (size_t l = 0; l < lanes; l++) {
                const int base = m->driven[2 * d + 1];
                x[m->driven[2 * d] * lanes + l] = relative[d * lanes + l] + (base < 0 ? 0.0 : x[base * lanes + l]);
            }
}

/* What the accelerations of driven joints change by, relative[blocks][drives][lanes], along directions in k, t and inputs */
static enum outcome prescribe(struct system *s, const struct ccgen_arguments *at, const struct directions *along,
                              double *relative)
{
    const struct ccgen_model *m = s->model;
    const size_t lanes = m->derivatives->lanes, size = along->blocks * lanes;
    const struct mark mark = s->arena->top;
    double *k = TAKE_ZEROS(s->arena, double, (size * m->constants)), *t = TAKE_ZEROS(s->arena, double, size);
    double *inputs = TAKE_ZEROS(s->arena, double, (size * m->inputs));
    const struct ccgen_arguments *by = &along->by, moved = {.k = k, .t = t, .inputs = inputs};
    const int none = s->arena->ran_out, first_k = along->first[MOVES_K], first_t = along->first[MOVES_T];
    if (!none) {
        const size_t of_k = along->count[MOVES_K] * lanes, of_t = along->count[MOVES_T] * lanes;
        if (of_k)
            memcpy(k + first_k * lanes * m->constants, by->k, of_k * m->constants * sizeof *k);
        if (of_t) {
            memcpy(t + first_t * lanes, by->t, of_t * sizeof *t);
            memcpy(inputs + first_t * lanes * m->inputs, by->inputs, of_t * m->inputs * sizeof *inputs);
        }
        m->derivatives->prescribed(at, &moved, along->blocks, relative);
    }
    give_back(s->arena, mark);
    return none ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
}

/* Take what driven joints bring, x, to the right-hand sides: f - M x, y - A x. */
static enum outcome move_driven(struct system *s, const struct ccgen_arguments *at, const struct directions *along,
                                struct sides *sides)
{
    const struct ccgen_model *m = s->model;
    const size_t n = s->n, rows = m->rows, lanes = m->derivatives->lanes, blocks = along->blocks;
    sides->forced = TAKE_ZEROS(s->arena, double, (blocks * n * lanes));
    double *relative = TAKE(s->arena, double, (blocks * lanes * m->drives));
    double *x = TAKE(s->arena, double, n), *p = TAKE(s->arena, double, n), *rate = TAKE(s->arena, double, rows);
    const enum outcome outcome = s->arena->ran_out ? OUTCOME_NO_MEMORY : prescribe(s, at, along, relative);
    for (size_t j = 0; j < blocks * lanes && !outcome; j++) {
        const size_t b = j / lanes, l = j % lanes;
        double *forced = sides->forced + b * n * lanes;
        if (!l)
            drive(m, lanes, relative + b * lanes * m->drives, forced);
        take_lane(forced, n, lanes, l, x);
        m->momentum(s->k, at->q, x, p);
        m->closure_rate(s->k, at->q, x, rate);
        double *f = sides->right + b * (n + rows) * lanes + l;
        for (size_t i = 0; i < n; i++)
            f[i * lanes] -= p[i];
        for (size_t i = 0; i < rows; i++)
            f[(n + i) * lanes] -= rate[i];
    }
    return outcome;
}

/* One direction by the core's own ways; *missed grows to what rows miss by, *size to how large it is. */
static enum outcome solve_one(struct system *s, const double *q, const double *f, const double *y, double *du,
                              double *Lambda, double *missed, double *size)
{
    const struct mark mark = s->arena->top;
    double *rate = TAKE(s->arena, double, s->model->rows);
    enum outcome outcome = s->arena->ran_out ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    if (!outcome)
        outcome = system_impulse(s, q, f, y, RANK_TOLERANCE, du, Lambda);
    if (!outcome) {
        s->model->closure_rate(s->k, q, du, rate);
        for (int k = 0; k < s->rows_on; k++) {
            const int i = s->on[k];
            *missed = fmax(*missed, fabs(rate[i] - y[i]));
            *size = fmax(*size, fabs(y[i]));
        }
        for (int i = 0; i < s->n; i++)
            *size = fmax(*size, s->length / s->unit[i] * fabs(du[i]));
    }
    give_back(s->arena, mark);
    return outcome;
}

static enum outcome solve_all(struct system *s, const double *q, size_t blocks, const double *right, double *tangents,
                              double *miss)
{
    const size_t n = s->n, rows = s->model->rows, lanes = s->model->derivatives->lanes;
    double missed = 0.0, size = DBL_MIN;
    double *f = TAKE(s->arena, double, n), *y = TAKE(s->arena, double, rows);
    double *du = TAKE(s->arena, double, n), *Lambda = TAKE(s->arena, double, rows);
    enum outcome outcome = s->arena->ran_out ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    for (size_t j = 0; j < blocks * lanes && !outcome; j++) {
        const size_t b = j / lanes, l = j % lanes;
        double *found = tangents + b * (n + rows) * lanes;
        const double *side = right + b * (n + rows) * lanes;
        take_lane(side, n, lanes, l, f);
        take_lane(side + n * lanes, rows, lanes, l, y);
        outcome = solve_one(s, q, f, y, du, Lambda, &missed, &size);
        if (!outcome) {
            put_lane(found, n, lanes, l, du);
            put_lane(found + n * lanes, rows, lanes, l, Lambda);
        }
    }
    *miss = missed / size;
    return outcome;
}

enum outcome acceleration_tangents(struct system *s, double t, const double *q, const double *u, const double *u_dot,
                                   const double *lambda, const struct directions *along, double *tangents, double *miss)
{
    const struct ccgen_derivatives *d = s->model->derivatives;
    const size_t nu = s->n * d->lanes, ny = s->model->rows * d->lanes, blocks = along->blocks;
    const struct mark mark = s->arena->top;
    struct sides sides = {TAKE(s->arena, double, (blocks * (nu + ny))), NULL};
    double *cs = d->cosines ? TAKE(s->arena, double, (2 * (size_t)d->angles)) : NULL;
    enum outcome outcome = s->arena->ran_out ? OUTCOME_NO_MEMORY : supply_inputs(s, t, q, u);
    const struct ccgen_arguments at = {
        .k = s->k, .q = q, .u = u, .t = &t, .inputs = s->inputs, .u_dot = u_dot, .multipliers = lambda, .cs = cs};
    const struct ccgen_arguments solved = {.f = sides.right, .y = sides.right + nu};
    *miss = -1.0;
    if (!outcome && cs)
        d->cosines(s->k, q, cs);
    if (!outcome)
        outcome = add_residuals(s, &at, along, sides.right);
    if (!outcome && d->prescribed && (along->count[MOVES_T] || along->count[MOVES_K]))
        outcome = move_driven(s, &at, along, &sides);
    if (!outcome && (s->refine || d->solve(&at, &solved, along->blocks, tangents)))
        outcome = solve_all(s, q, blocks, sides.right, tangents, miss);
    for (size_t b = 0; b < blocks && sides.forced && !outcome; b++)
        for (size_t i = 0; i < nu; i++)
            tangents[b * (nu + ny) + i] += sides.forced[b * nu + i];
    give_back(s->arena, mark);
    return outcome;
}

enum outcome impulse_tangents(struct system *s, const double *q, int blocks, const double *right, double *tangents)
{
    const struct ccgen_derivatives *d = s->model->derivatives;
    const struct mark mark = s->arena->top;
    double missed;
    const struct ccgen_arguments at = {.k = s->k, .q = q};
    const struct ccgen_arguments sides = {.f = right, .y = right + s->n * d->lanes};
    enum outcome outcome = OUTCOME_DONE;
    if (s->refine || d->solve(&at, &sides, blocks, tangents))
        outcome = solve_all(s, q, blocks, right, tangents, &missed);
    give_back(s->arena, mark);
    return outcome;
}

void collocate_tangents(int n, int stages, int width, double h, const double *A, const double *twice, const double *J,
                        double *K)
{
    for (int j = 0; j < stages; j++)
        for (int m = 0; m < n; m++)
            for (int i = 0; i < stages; i++) {
                const double by_q = -h * h * twice[i * stages + j], by_u = -h * A[i * stages + j];
                const double *from = J + (size_t)i * n * width + m;
                double *to = K + ((size_t)(j * n + m) * stages + i) * n;
                for (int l = 0; l < n; l++)
                    to[l] = by_q * from[l * width] + by_u * from[l * width + n];
                if (i == j)
                    to[m] += 1.0;
            }
}

void tangents_at_start(int n, int stages, int width, double h, const double *c, double *J)
{
    for (int j = 0; j < stages; j++)
        for (int i = 0; i < n; i++) {
            double *row = J + ((size_t)j * n + i) * width;
            for (int l = 0; l < n; l++)
                row[n + l] += h * c[j] * row[l];
        }
}
