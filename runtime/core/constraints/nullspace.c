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
#include <stdlib.h>
#include <string.h>

#include "algebra/cholesky.h"
#include "algebra/orthogonal.h"
#include "constraints/active_set.h"

enum { PASSES = 3 }; /* of refinement */
const double RANK_TOLERANCE = CCGEN_LIMIT(1e-10, 4e-5), RANK_TOLERANCE_PROJECTED = CCGEN_LIMIT(1e-5, 6e-3);
static const double REFINED_ENOUGH = CCGEN_LIMIT(1e-12, 5e-6); /* a last correction smaller than this is rounding */

/* Least-norm multipliers with A^T lambda = force: a second factorisation, of the triangle's rows. */
static void least_norm(int n, int rows, int rank, const double *g, const double *diagonal, const int *order,
                       const double *length, const double *weight, const double *beta, double *force, double *work,
                       double *lambda)
{
    double *rows_of = work, *d = rows_of + (size_t)rows * rank, *b = d + rank, *x = b + rank;
    reflect(n, rank, g, beta, 1, force);
    for (int k = 0; k < rank; k++)
        for (int j = 0; j < rows; j++) {
            const double entry = j < k ? 0.0 : j == k ? diagonal[k] : g[(size_t)j * n + k];
            rows_of[(size_t)k * rows + order[j]] = entry * length[order[j]] * weight[order[j]];
        }
    memset(lambda, 0, rows * sizeof *lambda);
    memcpy(x, force, rank * sizeof *x);
    const int kept = reduce_columns(rows, rank, rows_of, 0.0, d, b, NULL);
    solve_transposed_triangle(rows, kept, rows_of, d, x);
    memcpy(lambda, x, kept * sizeof *lambda);
    reflect(rows, kept, rows_of, b, 0, lambda);
    for (int j = 0; j < rows; j++)
        lambda[j] *= weight[j];
}

/* The rows of A, then those of driven joints, then those of held contacts, as columns of g; their right-hand sides from
 * y[rows + held]; lengths that make them comparable. */
static void write_rows(struct system *s, const double *q, int held, const double *y, const double *t, double *g,
                       double *right, double *length)
{
    const struct ccgen_model *m = s->model;
    const size_t n = s->n, closed = m->rows, fixed = closed + m->drives, rows = fixed + held;
    if (closed)
        m->closure_jacobian(s->k, q, g); /* rows of A are the columns of A^T */
    memcpy(right, y, closed * sizeof *right);
    memset(g + closed * n, 0, m->drives * n * sizeof *g);
    memset(right + closed, 0, m->drives * sizeof *right);
    for (int d = 0; d < m->drives; d++) {
        g[(closed + d) * n + m->driven[2 * d]] = 1.0;
        if (m->driven[2 * d + 1] >= 0)
            g[(closed + d) * n + m->driven[2 * d + 1]] = -1.0;
    }
    if (m->drives && t)
        m->prescribed(s->k, *t, right + closed);
    for (int j = 0; j < held; j++)
        active_row(s, q, j, 0, g + (fixed + j) * n);
    memcpy(right + fixed, y + closed, held * sizeof *right);
    for (size_t j = 0; j < rows; j++) {
        double sum = 0.0;
        for (size_t i = 0; i < n; i++)
            sum += g[j * n + i] * g[j * n + i];
        length[j] = sqrt(sum);
    }
    for (size_t j = 0; j < closed; j++) { /* both rows of a pin by the longer, one alone by at least the size of the
                                           * mechanism: a row that vanishes must be seen */
        const size_t other = m->partner[j];
        if (other == j)
            length[j] = fmax(length[j], s->length);
        else if (other > j)
            length[j] = length[other] = fmax(fmax(length[j], length[other]), DBL_MIN);
    }
    for (size_t j = fixed; j < rows; j++)
        length[j] = fmax(length[j], DBL_MIN);
    for (size_t j = 0; j < rows; j++)
        for (size_t i = 0; i < n; i++)
            g[j * n + i] /= length[j];
}

/* The rows of the closure and of driven joints as columns of room[0], factorised; their rank, or -1 when memory runs out */
struct factors {
    double *g, *length, *diagonal, *beta, *right;
    int *order;
};

static int factorise_rows(struct system *s, const double *q, struct factors *f)
{
    const size_t n = s->n, rows = s->model->rows + s->model->drives;
    f->g = malloc((rows * n + 4 * rows + 1) * sizeof *f->g);
    f->order = malloc((rows + 1) * sizeof *f->order);
    if (!f->g || !f->order)
        return -1;
    f->right = f->g + rows * n;
    f->length = f->right + rows;
    f->diagonal = f->length + rows;
    f->beta = f->diagonal + rows;
    memset(s->bias, 0, s->model->rows * sizeof *s->bias);
    write_rows(s, q, 0, s->bias, NULL, f->g, f->right, f->length);
    for (size_t j = 0; j < rows; j++)
        f->order[j] = (int)j;
    return reduce_columns((int)n, (int)rows, f->g, RANK_TOLERANCE, f->diagonal, f->beta, f->order);
}

int row_rank(struct system *s, const double *q, double *nearest)
{
    struct factors f;
    const int rank = factorise_rows(s, q, &f);
    *nearest = 1.0;
    for (int k = 0; k < rank; k++)
        *nearest = fmin(*nearest, fabs(f.diagonal[k] / f.diagonal[0]));
    free(f.g);
    free(f.order);
    return rank;
}

int left_null_vector(struct system *s, const double *q, int number, double *lambda)
{
    const int n = s->n, rows = s->model->rows + s->model->drives;
    struct factors f;
    const int rank = factorise_rows(s, q, &f), lost = rank >= 0 && rank + number < rows;
    if (lost) {
        double *x = f.g + (size_t)(rank + number) * n;
        memset(lambda, 0, rows * sizeof *lambda);
        lambda[f.order[rank + number]] = 1.0 / f.length[f.order[rank + number]];
        for (int k = rank - 1; k >= 0; k--) {
            for (int j = k + 1; j < rank; j++)
                x[k] -= f.g[(size_t)j * n + k] * x[j];
            x[k] /= f.diagonal[k];
            lambda[f.order[k]] = -x[k] / f.length[f.order[k]];
        }
    }
    free(f.g);
    free(f.order);
    return lost;
}

double rank_margin(struct system *s, const double *q)
{
    double nearest;
    row_rank(s, q, &nearest);
    return nearest;
}

/* The last correction of x[n], or of what has at least the size `whole`, was more[count] of orthonormal motions. */
static void note_inexact(struct system *s, int n, const double *x, int count, const double *more, double whole)
{
    double last = 0.0;
    for (int i = 0; i < n; i++)
        whole = fmax(whole, fabs(x[i]));
    for (int j = 0; j < count; j++)
        last = fmax(last, fabs(more[j]));
    if (whole > 0.0 && last > REFINED_ENOUGH * whole)
        s->refinement_residual = fmax(s->refinement_residual, last / whole);
}

/* Orthonormal motions null[n - rank][n] that no row sees, from the factors of the rows, and their masses mass[n - rank][n - rank];
 * p[n] is scratch. */
static void write_null_motions(const struct system *s, const double *q, int rank, const double *g, const double *beta,
                               double *null, double *mass, double *p)
{
    const size_t n = s->n, free_ = n - rank;
    for (size_t j = 0; j < free_; j++) {
        double *column = null + j * n;
        memset(column, 0, n * sizeof *column);
        column[rank + j] = 1.0;
        reflect((int)n, rank, g, beta, 0, column);
        s->model->momentum(s->k, q, column, p);
        for (size_t i = 0; i <= j; i++) {
            double sum = 0.0;
            for (size_t l = 0; l < n; l++)
                sum += null[i * n + l] * p[l];
            mass[i * free_ + j] = mass[j * free_ + i] = sum;
        }
    }
}

enum outcome solve_in_nullspace(struct system *s, const double *q, int held, const double *y, const double *t,
                                double nearest, affine *residual, const void *context, double *x, double *lambda)
{
    const struct ccgen_model *m = s->model;
    const size_t n = s->n, fixed = m->rows + m->drives, rows = fixed + held;
    double *work = malloc((rows * n + rows * rows + 9 * rows + 2 * n * n + 3 * n) * sizeof *work);
    int *order = malloc((rows + 1) * sizeof *order);
    enum outcome outcome = OUTCOME_NO_MEMORY;
    s->rank_deficient++;
    if (!work || !order)
        goto end;
    outcome = OUTCOME_INTERRUPTED;
    if (interrupted(s->interruption, 0))
        goto end;
    double *right = work, *every = right + rows, *g = every + rows, *diagonal = g + rows * n, *beta = diagonal + rows;
    double *length = beta + rows, *weight = length + rows, *null = weight + rows, *mass = null + n * n,
           *b = mass + n * n;
    double *p = b + n, *more = p + n;
    write_rows(s, q, held, y, t, g, right, length);
    for (size_t j = 0; j < rows; j++)
        order[j] = (int)j;
    const int rank = reduce_columns((int)n, (int)rows, g, nearest, diagonal, beta, order);
    const size_t free_ = n - rank;
    for (size_t j = 0; j < rows; j++)
        weight[j] = j < fixed ? 1.0 : s->active->weight[j - fixed];
    memset(x, 0, n * sizeof *x);
    for (int k = 0; k < rank; k++)
        x[k] = right[order[k]] / length[order[k]];
    solve_transposed_triangle((int)n, rank, g, diagonal, x);
    reflect((int)n, rank, g, beta, 0, x);
    write_null_motions(s, q, rank, g, beta, null, mass, p);
    outcome = OUTCOME_NOT_FINITE;
    if (cholesky((int)free_, mass, (int)free_, NULL, 0.0, mass))
        goto end;
    residual(s, q, context, x, b);
    for (int pass = 0; pass < (s->refine ? PASSES : 1); pass++) { /* refined where masses differ by many orders */
        for (size_t j = 0; j < free_; j++) {
            more[j] = 0.0;
            for (size_t l = 0; l < n; l++)
                more[j] -= null[j * n + l] * b[l];
        }
        cholesky_solve((int)free_, mass, more);
        for (size_t j = 0; j < free_; j++)
            for (size_t l = 0; l < n; l++)
                x[l] += more[j] * null[j * n + l];
        residual(s, q, context, x, b);
    }
    if (s->refine && free_)
        note_inexact(s, (int)n, x, (int)free_, more, t ? s->acceleration_scale : 0.0);
    least_norm((int)n, (int)rows, rank, g, diagonal, order, length, weight, beta, b, more + n, every);
    memcpy(lambda, every, m->rows * sizeof *lambda);
    memcpy(lambda + m->rows, every + fixed, held * sizeof *lambda);
    outcome = OUTCOME_DONE;
end:
    free(order);
    free(work);
    return outcome;
}
