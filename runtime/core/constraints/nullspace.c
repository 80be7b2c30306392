/* Motion under rows, of closure and of held contacts, that are, or nearly are, dependent (docs/theory, section 8).
 *
 * Null-space method on the unreduced equations: an orthogonal factorisation with pivoting of A^T finds the rows that count;
 * the part of the motion that they fix follows from them, the rest from the equations of motion projected onto their null
 * space (eq. 8.2). A is never squared, so a row that almost depends on others costs digits in proportion to its distance from
 * them, not to the square. Multipliers are those of least norm. (P. Businger, G. H. Golub, Numerische Mathematik 7, 1965;
 * E. Bayo, J. Garcia de Jalon, Kinematic and Dynamic Simulation of Multibody Systems, 1994, section 5.2.)
 */
#include "constraints/nullspace.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "algebra/cholesky.h"
#include "base/tolerances.h"
#include "constraints/active_set.h"
#include "constraints/branch.h"
#include "constraints/rows.h"

enum { PASSES = 3 }; /* of refinement */

/* With room for all rows of the closure, as the model gives them */
static void take_factors(struct system *s, struct factors *f, size_t rows)
{
    const size_t n = s->n, all = rows + s->model->rows - s->rows_on;
    struct arena *arena = s->arena;
    f->g = TAKE(arena, double, (all * n));
    f->length = TAKE(arena, double, all);
    f->diagonal = TAKE(arena, double, rows);
    f->beta = TAKE(arena, double, rows);
    f->right = TAKE(arena, double, rows);
    f->order = TAKE(arena, int, rows);
}

/* The rows of A that are on, then those of driven joints, then those of held contacts, as columns of g; their right-hand sides from
 * y[all rows of A + held]; lengths that make them comparable. push[contacts] are zeros. */
static void write_rows(struct system *s, const double *q, int held, const double *y, const double *t, double *push,
                       const struct factors *f)
{
    const size_t closed = s->rows_on;
    scaled_closure_rows(s, q, f->g, f->length);
    keep_rows_on(s, f->g);
    for (size_t k = 0; k < closed; k++) {
        f->length[k] = f->length[s->on[k]];
        f->right[k] = y[s->on[k]];
    }
    scaled_other_rows(s, q, held, y + s->model->rows, t, push, f->g + closed * s->n, f->length + closed,
                      f->right + closed);
}

/* The rows of the closure and of driven joints, factorised in what is taken from the arena; their rank, or -1 when memory runs out */
static int factorise_rows(struct system *s, const double *q, struct factors *f)
{
    const size_t n = s->n, rows = s->rows_on + s->model->drives;
    const double *closed = TAKE_ZEROS(s->arena, double, s->model->rows);
    take_factors(s, f, rows);
    if (s->arena->ran_out)
        return -1;
    write_rows(s, q, 0, closed, NULL, NULL, f);
    for (size_t j = 0; j < rows; j++)
        f->order[j] = (int)j;
    return reduce_columns((int)n, (int)rows, f->g, RANK_TOLERANCE, f->diagonal, f->beta, f->order);
}

int row_rank(struct system *s, const double *q, double *nearest)
{
    const struct mark mark = s->arena->top;
    struct factors f;
    const int rank = factorise_rows(s, q, &f);
    *nearest = 1.0;
    for (int k = 0; k < rank; k++)
        *nearest = fmin(*nearest, fabs(f.diagonal[k] / f.diagonal[0]));
    give_back(s->arena, mark);
    return rank;
}

int free_motions(struct system *s, const double *q, double *motions)
{
    const int n = s->n;
    const struct mark mark = s->arena->top;
    struct factors f = {0};
    if (is_place_on_branch(s, q) && !s->model->drives) {
        const int d = s->branch->freedom;
        for (int j = 0; j < d; j++)
            for (int i = 0; i < n; i++)
                motions[(size_t)j * n + i] = branch_tangents(s->branch)[(size_t)j * n + i] * s->unit[i];
        return n - d;
    }
    const int rank = s->rows_on + s->model->drives ? factorise_rows(s, q, &f) : 0;
    for (int j = rank; rank >= 0 && j < n; j++) {
        double *x = motions + (size_t)(j - rank) * n;
        memset(x, 0, n * sizeof *x);
        x[j] = 1.0;
        reflect(n, rank, f.g, f.beta, 0, x);
        for (int i = 0; i < n; i++)
            x[i] *= s->unit[i];
    }
    give_back(s->arena, mark);
    return rank;
}

/* The row number of the closure, or of driven joints behind all of these, from its number among those that are on and of driven joints */
static int place_of_row(const struct system *s, int number)
{
    return number < s->rows_on ? s->on[number] : number - s->rows_on + s->model->rows;
}

/* weight[rows + drives] with which rows, column number `column` of the factors among them and `before` others, come to cancel */
static void cancelling(const struct system *s, const struct factors *f, int before, int column, double *weight)
{
    const int n = s->n;
    double *x = f->g + (size_t)column * n;
    memset(weight, 0, (s->model->rows + s->model->drives) * sizeof *weight);
    weight[place_of_row(s, f->order[column])] = 1.0 / f->length[f->order[column]];
    for (int k = before - 1; k >= 0; k--) {
        for (int j = k + 1; j < before; j++)
            x[k] -= f->g[(size_t)j * n + k] * x[j];
        x[k] /= f->diagonal[k];
        weight[place_of_row(s, f->order[k])] = -x[k] / f->length[f->order[k]];
    }
}

int left_null_vector(struct system *s, const double *q, int number, double *lambda)
{
    const int rows = s->rows_on + s->model->drives;
    const struct mark mark = s->arena->top;
    struct factors f;
    const int rank = factorise_rows(s, q, &f), lost = rank >= 0 && rank + number < rows;
    if (lost)
        cancelling(s, &f, rank, rank + number, lambda);
    give_back(s->arena, mark);
    return lost;
}

double rank_margin(struct system *s, const double *q)
{
    double nearest;
    row_rank(s, q, &nearest);
    return nearest;
}

/* The last correction of x, or of what has at least the size `whole`, was more[count] of motions that are orthonormal in units. */
static void note_inexact(struct system *s, const double *x, int count, const double *more, double whole)
{
    double last = 0.0;
    whole = fmax(whole, fastest(s, x));
    for (int j = 0; j < count; j++)
        last = fmax(last, fabs(more[j]));
    if (whole > 0.0 && last > REFINED_ENOUGH * whole)
        s->refinement_residual = fmax(s->refinement_residual, last / whole);
}

/* Motions null[n - rank][n] that no row sees, orthonormal in units of the coordinates, from the factors of the rows */
static void write_null_motions(const struct system *s, int rank, const double *g, const double *beta, double *null)
{
    const size_t n = s->n, free_ = n - rank;
    for (size_t j = 0; j < free_; j++) {
        double *column = null + j * n;
        memset(column, 0, n * sizeof *column);
        column[rank + j] = 1.0;
        reflect((int)n, rank, g, beta, 0, column);
        for (size_t i = 0; i < n; i++)
            column[i] *= s->unit[i];
    }
}

/* mass[count][count] of motions null[count][n]; p[n] is scratch. */
static void write_masses(const struct system *s, const double *q, size_t count, const double *null, double *mass,
                         double *p)
{
    const size_t n = s->n;
    for (size_t j = 0; j < count; j++) {
        s->model->momentum(s->k, q, null + j * n, p);
        for (size_t i = 0; i <= j; i++) {
            double sum = 0.0;
            for (size_t l = 0; l < n; l++)
                sum += null[i * n + l] * p[l];
            mass[i * count + j] = mass[j * count + i] = sum;
        }
    }
}

/* Correct x[n] along the motions null[count][n], with the factor of their masses, by more[count] of them, for what the forces b[n] miss. */
static void correct_along(size_t n, size_t count, const double *null, const double *mass, const double *b, double *more,
                          double *x)
{
    for (size_t j = 0; j < count; j++) {
        more[j] = 0.0;
        for (size_t l = 0; l < n; l++)
            more[j] -= null[j * n + l] * b[l];
    }
    cholesky_solve((int)count, mass, more);
    for (size_t j = 0; j < count; j++)
        for (size_t l = 0; l < n; l++)
            x[l] += more[j] * null[j * n + l];
}

static enum outcome take_nullspace(struct system *s, size_t rows, struct nullspace *z)
{
    const size_t n = s->n;
    struct arena *arena = s->arena;
    take_factors(s, &z->factors, rows);
    take_least_norm(arena, &z->least_norm, rows);
    z->particular = TAKE(arena, double, n);
    z->null = TAKE(arena, double, (n * n));
    z->mass = TAKE(arena, double, (n * n));
    z->b = TAKE(arena, double, n);
    z->more = TAKE(arena, double, n);
    z->every = TAKE(arena, double, rows);
    return arena->ran_out ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
}

/* The motion of least size in units that the rows ask for */
static void write_particular(const struct system *s, const struct nullspace *z)
{
    const struct factors *f = &z->factors;
    double *x = z->particular;
    memset(x, 0, (size_t)s->n * sizeof *x);
    for (int k = 0; k < z->rank; k++)
        x[k] = f->right[f->order[k]] / f->length[f->order[k]];
    solve_transposed_triangle(s->n, z->rank, f->g, f->diagonal, x);
    reflect(s->n, z->rank, f->g, f->beta, 0, x);
    for (int i = 0; i < s->n; i++)
        x[i] *= s->unit[i];
}

/* x[n] = sum of z[freedom] times the tangents T, which are in units */
static void move_along(const struct system *s, const double *T, int freedom, const double *z, double *x)
{
    for (int j = 0; j < freedom; j++)
        for (int i = 0; i < s->n; i++)
            x[i] += z[j] * T[(size_t)j * s->n + i] * s->unit[i];
}

/* Motions along the system's branch (eq. 8.9), which rows of driven joints and of held contacts leave: those of the closure are kept by any. Rates of driven joints as prescribed at *t,
 * or speed[drives], or none. push[contacts] are zeros. */
static enum outcome factorise_along_branch(struct system *s, const double *q, int held, const double *y,
                                           const double *t, const double *speed, double *push, double nearest,
                                           struct nullspace *z)
{
    const struct branch *b = s->branch;
    const struct factors *f = &z->factors;
    const double *T = branch_tangents(b);
    const int n = s->n, d = b->freedom, drives = s->model->drives, rows = drives + held;
    const struct mark mark = s->arena->top;
    double *g = TAKE(s->arena, double, (size_t)rows *n), *x = TAKE_ZEROS(s->arena, double, d);
    enum outcome outcome = s->arena->ran_out ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    memset(z->particular, 0, n * sizeof *z->particular);
    if (!outcome && t)
        outcome = branch_bias(s, z->particular);
    if (outcome)
        goto end;
    scaled_other_rows(s, q, held, y, t, push, g, f->length, f->right);
    if (speed)
        memcpy(f->right, speed, drives * sizeof *speed);
    for (int k = 0; k < rows; k++) {
        f->order[k] = k;
        f->right[k] /= f->length[k];
        for (int i = 0; i < n; i++)
            f->right[k] -= g[(size_t)k * n + i] * z->particular[i] / s->unit[i];
        for (int i = 0; i < d; i++) {
            double sum = 0.0;
            for (int l = 0; l < n; l++)
                sum += g[(size_t)k * n + l] * T[(size_t)i * n + l];
            f->g[(size_t)k * d + i] = sum;
        }
    }
    /* rows have as many digits less as tangents have */
    const double known = fmin(nearest / nearest_margin(s), fmax(nearest, RANK_TOLERANCE_PROJECTED));
    const int count = reduce_columns(d, rows, f->g, known, f->diagonal, f->beta, f->order);
    z->along = s->model->rows;
    z->rank = b->rank + count;
    for (int k = 0; k < count; k++)
        x[k] = f->right[f->order[k]];
    solve_transposed_triangle(d, count, f->g, f->diagonal, x);
    reflect(d, count, f->g, f->beta, 0, x);
    move_along(s, T, d, x, z->particular);
    for (int j = count; j < d; j++) {
        memset(x, 0, d * sizeof *x);
        x[j] = 1.0;
        reflect(d, count, f->g, f->beta, 0, x);
        memset(z->null + (size_t)(j - count) * n, 0, n * sizeof *z->null);
        move_along(s, T, d, x, z->null + (size_t)(j - count) * n);
    }
    write_masses(s, q, d - count, z->null, z->mass, z->b);
    if (cholesky(d - count, z->mass, d - count, NULL, 0.0, z->mass))
        outcome = OUTCOME_NOT_FINITE;
    prepare_least_norm(d, rows, count, f->g, f->diagonal, f->order, f->length, NULL, &z->least_norm);
end:
    give_back(s->arena, mark);
    return outcome;
}

enum outcome factorise_motions(struct system *s, const double *q, int held, const double *y, const double *t,
                               double nearest, struct nullspace *z)
{
    const int fixed = s->rows_on + s->model->drives, rows = fixed + held;
    *z = (struct nullspace){.q = q, .rows = rows, .fixed = fixed, .accelerates = t != NULL};
    const enum outcome outcome = take_nullspace(s, rows, z);
    double *push = TAKE_ZEROS(s->arena, double, s->model->contacts);
    const struct factors *f = &z->factors;
    s->rank_deficient++;
    if (outcome || s->arena->ran_out)
        return OUTCOME_NO_MEMORY;
    if (interrupted(s->interruption, 0))
        return OUTCOME_INTERRUPTED;
    if (is_place_on_branch(s, q))
        return factorise_along_branch(s, q, held, y + s->model->rows, t, NULL, push, nearest, z);
    write_rows(s, q, held, y, t, push, f);
    for (int j = 0; j < rows; j++)
        f->order[j] = j;
    z->rank = reduce_columns(s->n, rows, f->g, nearest, f->diagonal, f->beta, f->order);
    s->left_out = rows - z->rank;
    write_particular(s, z);
    write_null_motions(s, z->rank, f->g, f->beta, z->null);
    write_masses(s, q, s->n - z->rank, z->null, z->mass, z->b);
    const int free_ = s->n - z->rank;
    if (cholesky(free_, z->mass, free_, NULL, 0.0, z->mass))
        return OUTCOME_NOT_FINITE;
    prepare_least_norm(s->n, rows, z->rank, f->g, f->diagonal, f->order, f->length, NULL, &z->least_norm);
    return OUTCOME_DONE;
}

/* Multipliers of held contacts that balance z->b along the system's branch; those of the closure are not numbers. */
static void least_along_branch(const struct system *s, const struct nullspace *z, double *lambda)
{
    const int n = s->n, d = s->branch->freedom, drives = s->model->drives, held = z->rows - z->fixed;
    const double *T = branch_tangents(s->branch);
    for (int i = 0; i < d; i++) {
        z->more[i] = 0.0;
        for (int l = 0; l < n; l++)
            z->more[i] += T[(size_t)i * n + l] * s->unit[l] * z->b[l];
    }
    find_least_norm(d, drives + held, z->rank - s->branch->rank, z->factors.g, z->factors.beta, z->more, &z->least_norm,
                    z->every);
    for (int i = 0; i < s->rows_on; i++)
        z->every[drives + held + i] = NAN;
    spread_multipliers(s, z->every + drives + held, lambda);
    memcpy(lambda + z->along, z->every + drives, held * sizeof *lambda);
}

void choose_motion(struct system *s, const struct nullspace *z, affine *residual, const void *context, double *x,
                   double *lambda)
{
    const size_t n = s->n, free_ = n - z->rank;
    memcpy(x, z->particular, n * sizeof *x);
    residual(s, z->q, context, x, z->b);
    for (int pass = 0; pass < (s->refine ? PASSES : 1); pass++) { /* refined where masses differ by many orders */
        correct_along(n, free_, z->null, z->mass, z->b, z->more, x);
        residual(s, z->q, context, x, z->b);
    }
    if (s->refine && free_)
        note_inexact(s, x, (int)free_, z->more, z->accelerates ? s->acceleration_scale : 0.0);
    if (z->along) {
        least_along_branch(s, z, lambda);
        return;
    }
    for (size_t i = 0; i < n; i++)
        z->b[i] *= s->unit[i];
    find_least_norm((int)n, z->rows, z->rank, z->factors.g, z->factors.beta, z->b, &z->least_norm, z->every);
    spread_multipliers(s, z->every, lambda);
    memcpy(lambda + s->model->rows, z->every + z->fixed, (z->rows - z->fixed) * sizeof *lambda);
}

void momentum_residual(const struct system *s, const double *q, const void *context, const double *x, double *out)
{
    const double *f = context;
    s->model->momentum(s->k, q, x, out);
    for (int i = 0; i < s->n; i++)
        out[i] -= f[i];
}

void choose_jump(struct system *s, struct nullspace *z, const double *f, double *du, double *Lambda)
{
    memset(z->particular, 0, s->n * sizeof *z->particular);
    z->accelerates = 0;
    choose_motion(s, z, momentum_residual, f, du, Lambda);
}

enum outcome solve_in_nullspace(struct system *s, const double *q, int held, const double *y, const double *t,
                                double nearest, affine *residual, const void *context, double *x, double *lambda)
{
    const struct mark mark = s->arena->top;
    struct nullspace z;
    const enum outcome outcome = factorise_motions(s, q, held, y, t, nearest, &z);
    if (!outcome)
        choose_motion(s, &z, residual, context, x, lambda);
    give_back(s->arena, mark);
    return outcome;
}

/* Rates at which the rows of held contacts change, taken away; speeds of driven joints that u[n] has more than x[n] */
static void rates_to_keep(const struct system *s, const double *q, const double *u, const double *x, double *rates,
                          double *slips, double *held, double *speed)
{
    const struct ccgen_model *m = s->model;
    if (active_count(s))
        rates_of_active(s, q, x, s->active->rows, rates, slips, held);
    for (int j = 0; j < active_rows(s, 1); j++)
        held[j] = -held[j];
    for (int k = 0; k < m->drives; k++) {
        const int first = m->driven[2 * k], second = m->driven[2 * k + 1];
        speed[k] = u[first] - x[first] - (second < 0 ? 0.0 : u[second] - x[second]);
    }
}

enum outcome keep_velocities_along_branch(struct system *s, const double *q, double *u)
{
    const struct ccgen_model *m = s->model;
    const struct branch *b = s->branch;
    const int n = s->n, d = b->freedom, held = active_rows(s, 1), fixed = s->rows_on + m->drives, rows = fixed + held;
    const struct mark mark = s->arena->top;
    struct nullspace z = {.q = q, .rows = rows, .fixed = fixed};
    double *x = TAKE_ZEROS(s->arena, double, n), *f = TAKE(s->arena, double, n), *more = TAKE(s->arena, double, n);
    double *rates = TAKE(s->arena, double, m->contacts), *slips = TAKE(s->arena, double, m->contacts);
    double *wanted = TAKE(s->arena, double, held), *speed = TAKE(s->arena, double, m->drives);
    double *push = TAKE_ZEROS(s->arena, double, m->contacts), *in_chart = TAKE(s->arena, double, d);
    double *multipliers = TAKE(s->arena, double, m->rows + held);
    enum outcome outcome = take_nullspace(s, rows, &z);
    outcome = s->arena->ran_out ? OUTCOME_NO_MEMORY : outcome;
    if (outcome)
        goto end;
    for (int i = 0; i < d; i++) {
        in_chart[i] = 0.0;
        for (int l = 0; l < n; l++)
            in_chart[i] += b->chart[(size_t)i * n + l] * u[l] / s->unit[l];
    }
    move_along(s, branch_tangents(b), d, in_chart, x);
    rates_to_keep(s, q, u, x, rates, slips, wanted, speed);
    for (int i = 0; i < n; i++)
        more[i] = u[i] - x[i];
    m->momentum(s->k, q, more, f);
    outcome = factorise_along_branch(s, q, held, wanted, NULL, speed, push, RANK_TOLERANCE, &z);
    if (!outcome)
        choose_motion(s, &z, momentum_residual, f, more, multipliers);
    for (int i = 0; i < n && !outcome; i++)
        u[i] = x[i] + more[i];
end:
    give_back(s->arena, mark);
    return outcome;
}
