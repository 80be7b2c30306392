/* Triangles of a system that grows by an unknown at a time, its rows not exchanged (bordering: G. H. Golub, C. F. Van Loan, Matrix
 * Computations, 4th edition, 2013, section 3.2).
 *
 * A contact that joins adds a row and a column to the triangles of those before it, which stay as they are: trying all ways in the order
 * of a counter changes the last contacts alone most of the time. Without exchange of rows a pivot may be small where the system is
 * regular. Then nothing is said of that way.
 */
#include "complementarity/bordered.h"

#include <math.h>
#include <string.h>

#include "algebra/dot.h"
#include "base/tolerances.h"
#include "complementarity/ways.h"

/* All that impulses give, in units of the roots of compliances; rows that no impulse moves are zero. */
static void scale_columns(const struct friction_problem *c, const struct bordered *b)
{
    const size_t n = c->n, all = 2 * n;
    const double *root = c->root;
    for (size_t row = 0; row < all; row++) {
        const double bias = row < n ? c->bn[row] : c->bt[row - n];
        b->rate[row] = root[row] > 0.0 ? bias / root[row] : 0.0;
        for (size_t k = 0; k < n; k++) {
            const double *W = c->W + row * all;
            const double normal = root[row] * root[k], tangent = root[row] * root[n + k];
            const double alone = normal > 0.0 ? W[k] / normal : 0.0;
            const double limit = normal > 0.0 ? c->against[k] * W[n + k] / normal : 0.0;
            b->alone[k * all + row] = alone;
            b->held[k * all + row] = tangent > 0.0 ? W[n + k] / tangent : 0.0;
            b->slid[k * all + row] = alone + limit;
            b->slid[(n + k) * all + row] = alone - limit;
        }
    }
}

int take_bordered(const struct friction_problem *c, struct bordered *b)
{
    const size_t n = c->n, all = 2 * n;
    struct arena *arena = c->arena;
    *b = (struct bordered){
        .slid = TAKE(arena, double, (all * all)),
        .alone = TAKE(arena, double, (n * all)),
        .held = TAKE(arena, double, (n * all)),
        .rate = TAKE(arena, double, all),
        .lower = TAKE(arena, double, (all * all)),
        .upper = TAKE(arena, double, (all * all)),
        .y = TAKE(arena, double, all),
        .x = TAKE(arena, double, all),
        .column = TAKE(arena, const double *, all),
        .impulse = TAKE(arena, double, all),
        .after = TAKE(arena, double, all),
        .row = TAKE(arena, int, all),
        .before = TAKE(arena, int, (n + 1)),
        .beginning = TAKE(arena, enum beginning, (n + 1)),
    };
    if (arena->ran_out)
        return 1;
    scale_columns(c, b);
    b->before[0] = 0;
    b->beginning[0] = SOUND;
    return 0;
}

/* Whether the row of unknown m is a sum of multiples of the rows before it, in all columns: then no way with these rows is regular, whatever
 * joins later. Which multiples, its part of the triangle says. */
static int depends(const struct friction_problem *c, const struct bordered *b, int m)
{
    const size_t n = c->n, all = 2 * n;
    double *multiple = b->x;
    memcpy(multiple, b->lower + m * all, m * sizeof *multiple);
    for (int j = m - 1; j >= 0; j--)
        for (int k = 0; k < j; k++)
            multiple[k] -= multiple[j] * b->lower[j * all + k];
    for (size_t k = 0; k < all; k++) {
        const double *column = k < n ? b->alone + k * all : b->held + (k - n) * all;
        double left = column[b->row[m]], size = fabs(left);
        for (int j = 0; j < m; j++) {
            const double part = multiple[j] * column[b->row[j]];
            left -= part;
            size += fabs(part);
        }
        if (fabs(left) > RATE_ROUNDING * size)
            return 0;
    }
    return 1;
}

/* The rates that the normal impulse of contact i gives, with the friction that its kind brings */
static const double *column_of(const struct friction_problem *c, const struct bordered *b, int i, int kind)
{
    const size_t n = c->n;
    if (holds_fast(kind))
        return b->alone + 2 * n * i;
    return b->slid + 2 * n * (at_limit(c, i, kind) == c->against[i] ? (size_t)i : n + i);
}

/* One more unknown, with its column and its row */
static enum beginning add_unknown(const struct friction_problem *c, struct bordered *b, int m, int row,
                                  const double *column)
{
    const size_t all = 2 * (size_t)c->n;
    double *lower = b->lower + m * all, *upper = b->upper + m * all, largest = 0.0;
    b->row[m] = row;
    b->column[m] = column;
    for (int j = 0; j < m; j++) {
        upper[j] = column[b->row[j]] - dot(j, b->lower + j * all, upper);
        lower[j] = (b->column[j][row] - dot(j, lower, b->upper + j * all)) / b->upper[j * all + j];
        largest = fmax(largest, fmax(fabs(upper[j]), fabs(lower[j])));
    }
    upper[m] = column[row] - dot(m, lower, upper);
    b->y[m] = -b->rate[row] - dot(m, lower, b->y);
    if (fabs(upper[m]) > LEADING_PIVOT && largest * LEADING_PIVOT < 1.0)
        return SOUND;
    return depends(c, b, m) ? SINGULAR : UNSOUND;
}

enum beginning border(const struct friction_problem *c, const signed char *way, int i, struct bordered *b)
{
    const int kind = way[i];
    enum beginning found = b->beginning[i];
    int m = b->before[i];
    if (found == SOUND && kind < LEAST_ON)
        found = add_unknown(c, b, m++, i, column_of(c, b, i, kind));
    if (found == SOUND && holds_fast(kind))
        found = add_unknown(c, b, m++, c->n + i, b->held + 2 * (size_t)i * c->n);
    b->before[i + 1] = m;
    return b->beginning[i + 1] = found;
}

/* b->impulse[2n] of the way; of b->after what contacts give that do not push */
static void solve_triangles(const struct friction_problem *c, const signed char *way, const struct bordered *b)
{
    const size_t n = c->n, all = 2 * n;
    const int m = b->before[n];
    double *normal = b->impulse, *tangent = normal + n, *rate = b->after;
    memcpy(rate, b->rate, all * sizeof *rate);
    memset(tangent, 0, n * sizeof *tangent);
    for (size_t i = 0; i < n; i++) {
        normal[i] = way[i] < LEAST_ON || !c->least ? 0.0 : c->root[i] * c->least[i];
        for (size_t row = 0; normal[i] > 0.0 && row < all; row++)
            rate[row] += normal[i] * column_of(c, b, (int)i, way[i])[row];
    }
    for (int j = 0; j < m; j++) /* y is what it was when contacts joined, where all that do not push have no impulse */
        b->x[j] = c->least ? -rate[b->row[j]] - dot(j, b->lower + j * all, b->x) : b->y[j];
    for (int j = m - 1; j >= 0; j--) {
        b->x[j] /= b->upper[j * all + j];
        for (int i = 0; i < j; i++)
            b->x[i] -= b->x[j] * b->upper[j * all + i];
    }
    for (int j = 0; j < m; j++)
        b->impulse[b->row[j]] = b->x[j];
}

/* b->after[2n]: the rates that these impulses lead to */
static void add_rates(const struct friction_problem *c, const struct bordered *b)
{
    const size_t n = c->n;
    for (int j = 0; j < b->before[n]; j++)
        for (size_t row = 0; row < 2 * n; row++)
            b->after[row] += b->x[j] * b->column[j][row];
}

/* How much friction contact i has at most for a unit of its normal impulse, in the scales of both */
static double limit_ratio(const struct friction_problem *c, int i)
{
    return c->root[i] > 0.0 ? fabs(c->against[i]) * c->root[c->n + i] / c->root[i] : 0.0;
}

/* Whether the motion breaks the law at contact i: it approaches, or friction is the wrong way */
static int is_broken(const struct friction_problem *c, const signed char *way, int i, double load, double speed,
                     const struct bordered *b)
{
    const int n = c->n, kind = way[i];
    const double approach = -b->after[i], slip = b->after[n + i], normal = b->impulse[i];
    const double limit = limit_ratio(c, i) * normal;
    if (kind >= LEAST_ON && approach > SEEN_AT_ONCE * speed)
        return 1;
    if (!c->rough[i] || c->slides[i])
        return 0;
    if (holds_fast(kind))
        return fabs(b->impulse[n + i]) - limit > SEEN_AT_ONCE * load;
    const double along = at_limit(c, i, kind) > 0.0 ? slip : -slip;
    return along > SEEN_AT_ONCE * speed && limit > SEEN_AT_ONCE * load;
}

int is_ruled_out(const struct friction_problem *c, const signed char *way, double most, const struct bordered *b)
{
    const int n = c->n;
    double load = 0.0, speed = 0.0, sum = 0.0, pull = 0.0;
    if (b->beginning[n] != SOUND)
        return b->beginning[n] == SINGULAR;
    solve_triangles(c, way, b);
    for (int i = 0; i < n; i++) {
        const double least = c->least ? c->root[i] * c->least[i] : 0.0, normal = b->impulse[i];
        const double limit = limit_ratio(c, i);
        load = fmax(load, fmax(fmax(fabs(normal), limit * fabs(normal)), fmax(fabs(b->impulse[n + i]), least)));
        speed = fmax(speed, fmax(fabs(b->rate[i]), fabs(b->rate[n + i])));
        pull = fmax(pull, least - normal);
        sum += normal;
    }
    if (pull > SEEN_AT_ONCE * load || sum - most > SEEN_AT_ONCE * (load + most))
        return 1;
    add_rates(c, b);
    for (int i = 0; i < n; i++)
        if (is_broken(c, way, i, load, fmax(speed, load), b))
            return 1;
    return 0;
}
