/* Orthogonal factorisation; see orthogonal.h. */
#include "algebra/orthogonal.h"

#include <math.h>
#include <string.h>

#include "algebra/dot.h"

/* x <- x - factor v */
static void subtract(int n, double factor, const double *v, double *x)
{
    for (int i = 0; i < n; i++)
        x[i] -= factor * v[i];
}

enum { ABREAST = 16 /* columns of which sums are kept at a time */ };

/* The longest of columns k to `columns`, from row k on, the first where several are; the square of its length */
static int longest(int n, int columns, const double *g, int k, double *square)
{
    double squares[ABREAST];
    int best = k;
    *square = -1.0;
    for (int j = k; j < columns; j += ABREAST) {
        const int count = columns - j < ABREAST ? columns - j : ABREAST;
        dots(n - k, count, (size_t)n, NULL, g + (size_t)j * n + k, squares);
        for (int i = 0; i < count; i++)
            if (squares[i] > *square) {
                *square = squares[i];
                best = j + i;
            }
    }
    return best;
}

/* Reflect columns k + 1 to `columns` by v, which is column k from row k on. */
static void reflect_columns(int n, int columns, double *g, int k, double beta)
{
    double sums[ABREAST];
    const double *v = g + (size_t)k * n + k;
    for (int j = k + 1; j < columns; j += ABREAST) {
        const int count = columns - j < ABREAST ? columns - j : ABREAST;
        dots(n - k, count, (size_t)n, v, g + (size_t)j * n + k, sums);
        for (int i = 0; i < count; i++)
            subtract(n - k, beta * sums[i], v, g + (size_t)(j + i) * n + k);
    }
}

int reduce_columns(int n, int columns, double *g, double nearest, double *diagonal, double *beta, int *order)
{
    const int most = n < columns ? n : columns;
    double first = 0.0;
    for (int k = 0; k < most; k++) {
        double length;
        const int best = longest(n, order ? columns : k + 1, g, k, &length);
        length = sqrt(length);
        if (k == 0)
            first = length;
        if (!(length > nearest * first) || length == 0.0)
            return k;
        if (best != k) {
            for (int i = 0; i < n; i++) {
                const double swap = g[(size_t)k * n + i];
                g[(size_t)k * n + i] = g[(size_t)best * n + i];
                g[(size_t)best * n + i] = swap;
            }
            const int swap = order[k];
            order[k] = order[best];
            order[best] = swap;
        }
        double *v = g + (size_t)k * n;
        diagonal[k] = v[k] > 0.0 ? -length : length;
        v[k] -= diagonal[k];
        beta[k] = 2.0 / dot(n - k, v + k, v + k);
        reflect_columns(n, columns, g, k, beta[k]);
    }
    return most;
}

void reflect(int n, int rank, const double *g, const double *beta, int transposed, double *x)
{
    for (int step = 0; step < rank; step++) {
        const int k = transposed ? step : rank - 1 - step;
        const double *v = g + (size_t)k * n + k;
        subtract(n - k, beta[k] * dot(n - k, v, x + k), v, x + k);
    }
}

void solve_transposed_triangle(int n, int rank, const double *g, const double *diagonal, double *x)
{
    for (int k = 0; k < rank; k++) {
        for (int i = 0; i < k; i++)
            x[k] -= g[(size_t)k * n + i] * x[i];
        x[k] /= diagonal[k];
    }
}

void take_least_norm(struct arena *arena, struct least_norm *room, size_t columns)
{
    room->rows = TAKE(arena, double, (columns * columns));
    room->diagonal = TAKE(arena, double, columns);
    room->beta = TAKE(arena, double, columns);
    room->kept = 0;
}

void prepare_least_norm(int n, int columns, int rank, const double *g, const double *diagonal, const int *order,
                        const double *length, const double *weight, struct least_norm *room)
{
    for (int k = 0; k < rank; k++)
        for (int j = 0; j < columns; j++) {
            const double entry = j < k ? 0.0 : j == k ? diagonal[k] : g[(size_t)j * n + k];
            const double scaled = length ? entry * length[order[j]] : entry;
            room->rows[(size_t)k * columns + order[j]] = weight ? scaled * weight[order[j]] : scaled;
        }
    room->kept = reduce_columns(columns, rank, room->rows, 0.0, room->diagonal, room->beta, NULL);
}

void find_least_norm(int n, int columns, int rank, const double *g, const double *beta, double *b,
                     const struct least_norm *room, double *x)
{
    reflect(n, rank, g, beta, 1, b);
    memset(x, 0, columns * sizeof *x);
    memcpy(x, b, rank * sizeof *b);
    solve_transposed_triangle(columns, room->kept, room->rows, room->diagonal, x);
    memset(x + room->kept, 0, (columns - room->kept) * sizeof *x);
    reflect(columns, room->kept, room->rows, room->beta, 0, x);
}
