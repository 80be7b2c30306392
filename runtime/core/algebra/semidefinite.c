/* Symmetric positive semidefinite systems: Cholesky's factor where all pivots keep their digits, else the solution of least norm
 * by orthogonal factorisation, where a column nearer than DEPENDENT_PIVOT to the span of the others does not count. */
#include "algebra/semidefinite.h"

#include <string.h>

#include "algebra/cholesky.h"
#include "base/tolerances.h"

void take_semidefinite(struct arena *arena, struct semidefinite *room, size_t n)
{
    room->a = TAKE(arena, double, (n * n));
    room->right = TAKE(arena, double, n);
    room->diagonal = TAKE(arena, double, n);
    room->beta = TAKE(arena, double, n);
    room->order = TAKE(arena, int, n);
    take_least_norm(arena, &room->least_norm, n);
}

void solve_semidefinite(int n, const double *W, const double *r, double *x, struct semidefinite *room)
{
    memcpy(x, r, (size_t)n * sizeof *x);
    if (!cholesky(n, W, n, NULL, DEPENDENT_PIVOT, room->a)) {
        cholesky_solve(n, room->a, x);
        return;
    }
    memcpy(room->a, W, (size_t)n * n * sizeof *room->a); /* its rows are its columns */
    memcpy(room->right, r, (size_t)n * sizeof *r);
    for (int j = 0; j < n; j++)
        room->order[j] = j;
    const int rank = reduce_columns(n, n, room->a, DEPENDENT_PIVOT, room->diagonal, room->beta, room->order);
    prepare_least_norm(n, n, rank, room->a, room->diagonal, room->order, NULL, NULL, &room->least_norm);
    find_least_norm(n, n, rank, room->a, room->beta, room->right, &room->least_norm, x);
}

int solve_definite_well(int n, const double *W, double *x, double *scratch)
{
    if (cholesky(n, W, n, NULL, WELL_PIVOT, scratch))
        return 1;
    cholesky_solve(n, scratch, x);
    return 0;
}
