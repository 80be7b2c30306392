/* Ways in which Coulomb's law can hold at rough contacts.
 *
 * A way says of every contact whether it pushes or keeps its least impulse, and whether its friction is at one limit, at the
 * other, or holds it. Its impulses follow from one linear system.
 */
#include "complementarity/ways.h"

#include <math.h>
#include <string.h>

#include "algebra/elimination.h"
#include "base/tolerances.h"

enum { REFINEMENTS = 3 };

double at_limit(const struct friction_problem *c, int i, int kind)
{
    return c->slides[i] || kind == ON || kind == LEAST_ON ? c->against[i] : -c->against[i];
}

int holds_fast(int kind)
{
    return kind == HELD_FAST || kind == LEAST_HELD;
}

int unknowns_of_way(const struct friction_problem *c, const signed char *way, int *column)
{
    int m = 0;
    for (int i = 0; i < c->n; i++)
        if (way[i] < LEAST_ON)
            column[m++] = i;
    for (int i = 0; i < c->n; i++)
        if (holds_fast(way[i]))
            column[m++] = c->n + i;
    return m;
}

/* Rows of the linear system of a way: by what its unknowns have to change so that the rates of row[rows] become zero from what
 * they are with Pn and Pt, or without any (NULL). A[rows][m], x[rows]. */
static void rows_of_way(const struct friction_problem *c, const signed char *way, int m, const int *column, int rows,
                        const int *row, const double *Pn, const double *Pt, double *A, double *x)
{
    const int n = c->n;
    for (int i = 0; i < rows; i++) {
        const double *own = c->W + (size_t)row[i] * 2 * n;
        double size;
        x[i] = Pn ? -rate_of(c, row[i], Pn, Pt, &size) : row[i] < n ? -c->bn[row[i]] : -c->bt[row[i] - n];
        for (int j = 0; j < m; j++) {
            const int k = column[j], slides = k < n && !holds_fast(way[k]);
            A[i * m + j] = own[k] + (slides ? at_limit(c, k, way[k]) * own[n + k] : 0.0);
        }
    }
}

/* Impulse number k, normals and then tangents, changes by `by`, and friction at its limit with it. */
static void change(const struct friction_problem *c, const signed char *way, int k, double by, double *Pn, double *Pt)
{
    if (k >= c->n) {
        Pt[k - c->n] += by;
        return;
    }
    Pn[k] += by;
    if (!holds_fast(way[k]))
        Pt[k] = at_limit(c, k, way[k]) * Pn[k];
}

int impulses_of_way(const struct friction_problem *c, const signed char *way, double *A, double *x, int *column,
                    double *Pn, double *Pt)
{
    for (int i = 0; i < c->n; i++) {
        Pn[i] = way[i] < LEAST_ON || !c->least ? 0.0 : c->least[i];
        Pt[i] = holds_fast(way[i]) ? 0.0 : at_limit(c, i, way[i]) * Pn[i];
    }
    const int m = unknowns_of_way(c, way, column);
    rows_of_way(c, way, m, column, m, column, c->least ? Pn : NULL, Pt, A, x);
    if (m && !eliminate(m, A, x, SINGULAR_MODES))
        return 1;
    for (int j = 0; j < m; j++)
        change(c, way, column[j], x[j], Pn, Pt);
    return 0;
}

int impulses_of(const struct friction_problem *c, const char *push, const signed char *limit, double *Pn, double *Pt)
{
    const size_t n = c->n;
    const struct mark mark = c->arena->top;
    double *A = TAKE(c->arena, double, 4 * n * n), *x = TAKE(c->arena, double, 2 * n);
    int *column = TAKE(c->arena, int, 2 * n), wrong = 1;
    signed char *way = TAKE(c->arena, signed char, n);
    if (!c->arena->ran_out) {
        for (int i = 0; i < c->n; i++) {
            const int on = (limit[i] < 0) == (c->bt[i] >= 0.0);
            const int kind = !c->rough[i] || c->slides[i] ? ON : limit[i] == 0 ? HELD_FAST : on ? ON : BACK;
            way[i] = (signed char)(push[i] ? kind : LEAST_ON + kind);
        }
        wrong = impulses_of_way(c, way, A, x, column, Pn, Pt);
    }
    give_back(c->arena, mark);
    return wrong;
}

/* The way that impulses have taken: they push where they are above their least, and friction that is not at its limit holds. */
static void way_of(const struct friction_problem *c, const double *Pn, const double *Pt, signed char *way)
{
    const struct sizes of = sizes_of(c, Pn, Pt);
    for (int i = 0; i < c->n; i++) {
        const double extra = Pn[i] - (c->least ? c->least[i] : 0.0), limit = c->mu[i] * Pn[i];
        const int pushes = extra > 0.0 && scaled_rate(c, i, Pn, Pt, &of) <= CONSISTENT;
        const int limited = !(fabs(Pt[i]) < limit * (1.0 - 4.0 * DBL_EPSILON)),
                  on = (Pt[i] <= 0.0) == (c->bt[i] >= 0.0);
        const int kind = !c->rough[i] || c->slides[i] ? ON : !limited ? HELD_FAST : on ? ON : BACK;
        way[i] = (signed char)(pushes ? kind : LEAST_ON + kind);
    }
}

/* The rows that are at rest, also those of contacts that do not push: others may carry them, and know better what the motion is. */
static int rows_at_rest(const struct friction_problem *c, const double *Pn, const double *Pt, int *row)
{
    const struct sizes of = sizes_of(c, Pn, Pt);
    int rows = 0;
    for (int i = 0; i < 2 * c->n; i++)
        if (c->root[i] > 0.0 && fabs(scaled_rate(c, i, Pn, Pt, &of)) <= CONSISTENT)
            row[rows++] = i;
    return rows;
}

void refine_impulses(const struct friction_problem *c, double *Pn, double *Pt)
{
    const size_t n = c->n;
    const struct mark mark = c->arena->top;
    double *A = TAKE(c->arena, double, 4 * n * n), *x = TAKE(c->arena, double, 2 * n);
    double *normal = TAKE(c->arena, double, n), *tangent = TAKE(c->arena, double, n);
    int *column = TAKE(c->arena, int, 2 * n), *order = TAKE(c->arena, int, 2 * n), *row = TAKE(c->arena, int, 2 * n);
    signed char *way = TAKE(c->arena, signed char, n);
    double worst = coulomb_residual(c, Pn, Pt);
    for (int pass = 0; !c->arena->ran_out && pass < REFINEMENTS; pass++) {
        way_of(c, Pn, Pt, way);
        for (int i = 0; i < c->n; i++) { /* what is not unknown is what its way says */
            normal[i] = way[i] < LEAST_ON ? Pn[i] : c->least ? c->least[i] : 0.0;
            tangent[i] = holds_fast(way[i]) ? Pt[i] : at_limit(c, i, way[i]) * normal[i];
        }
        const int m = unknowns_of_way(c, way, column), rows = rows_at_rest(c, Pn, Pt, row);
        rows_of_way(c, way, m, column, rows, row, normal, tangent, A, x);
        const int rank = eliminate_dependent(rows, m, A, x, order, SINGULAR_MODES);
        for (int j = 0; j < rank; j++)
            change(c, way, column[order[j]], x[j], normal, tangent);
        const double left = coulomb_residual(c, normal, tangent);
        if (!rank || !(left < worst))
            break;
        worst = left;
        memcpy(Pn, normal, n * sizeof *Pn);
        memcpy(Pt, tangent, n * sizeof *Pt);
    }
    give_back(c->arena, mark);
}
