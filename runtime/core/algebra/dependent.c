/* Square systems whose rows depend on each other, or do not, but not nearly: the solution of least norm (orthogonal.h), which rounding does not change by more than a
 * few digits. */
#include "algebra/dependent.h"

#include <math.h>
#include <string.h>

#include "algebra/orthogonal.h"
#include "base/tolerances.h"

/* Times what is no pivot: what is left of a solution that is rounding */
static const double ROUNDED = 10.0;

/* root[n] = roots of the diagonal of W, in a unit that is a power of two: other units of W, a power of two apart, change no bit of them */
static void write_roots(int n, const double *W, double *root)
{
    double most = 0.0;
    int exponent = 0;
    for (int i = 0; i < n; i++)
        most = fmax(most, fabs(W[(size_t)i * (n + 1)]));
    frexp(most, &exponent);
    for (int i = 0; i < n; i++)
        root[i] = sqrt(ldexp(fabs(W[(size_t)i * (n + 1)]), -exponent));
}

/* Whether W x misses r by more than rounding */
static int misses(int n, const double *W, const double *r, const double *x, const double *root)
{
    double whole = 0.0, worst = 0.0;
    for (int i = 0; i < n; i++) {
        double left = -r[i], size = fabs(r[i]);
        for (int j = 0; j < n; j++) {
            left += W[(size_t)i * n + j] * x[j];
            size += fabs(W[(size_t)i * n + j] * x[j]);
        }
        worst = fmax(worst, fabs(left) / root[i]);
        whole = fmax(whole, size / root[i]);
    }
    return !(worst <= ROUNDED * DEPENDENT_PIVOT * whole);
}

int solve_dependent(struct arena *arena, int n, const double *W, const double *r, const double *weight, double *x)
{
    const struct mark mark = arena->top;
    double *g = TAKE(arena, double, (size_t)n *n), *diagonal = TAKE(arena, double, n), *beta = TAKE(arena, double, n),
           *length = TAKE(arena, double, n), *b = TAKE(arena, double, n), *root = TAKE(arena, double, n);
    int *order = TAKE(arena, int, n), wrong = 1;
    struct least_norm room;
    take_least_norm(arena, &room, n);
    if (arena->ran_out)
        goto end;
    for (int i = 0; i < n; i++)
        if (!(fabs(W[(size_t)i * (n + 1)]) > 0.0))
            goto end;
    write_roots(n, W, root);
    for (int i = 0; i < n; i++)
        b[i] = r[i] / root[i];
    for (int j = 0; j < n; j++) { /* columns of one length, of rows in units of the root of an energy */
        double square = 0.0;
        order[j] = j;
        for (int i = 0; i < n; i++) {
            const double entry = W[(size_t)i * n + j] / root[i];
            g[(size_t)j * n + i] = entry;
            square += entry * entry;
        }
        length[j] = sqrt(square);
        for (int i = 0; i < n; i++)
            g[(size_t)j * n + i] /= length[j];
    }
    const int rank = reduce_columns(n, n, g, DEPENDENT_PIVOT, diagonal, beta, order);
    if (!rank || !(fabs(diagonal[rank - 1]) > WELL_PIVOT))
        goto end;
    prepare_least_norm(n, n, rank, g, diagonal, order, length, weight, &room);
    find_least_norm(n, n, rank, g, beta, b, &room, x);
    for (int j = 0; j < n; j++)
        x[j] *= weight[j];
    wrong = misses(n, W, r, x, root);
end:
    give_back(arena, mark);
    return wrong;
}
