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

/* The longest of columns k to `columns`, from row k on, the first where several are; the square of its length. square_of[known] has those that are as they were, and -1 for
 * others. */
static int longest(int n, int columns, int known, const double *g, int k, double *square_of, double *square)
{
    double squares[ABREAST];
    int best = k;
    *square = -1.0;
    for (int j = k; j < columns;) {
        int count = 0;
        while (j + count < columns && count < ABREAST && (j + count >= known || square_of[j + count] < 0.0))
            count++;
        dots(n - k, count, (size_t)n, NULL, g + (size_t)j * n + k, squares);
        const int either = count ? count : 1; /* one that is known, where none is not */
        for (int i = 0; i < either; i++) {
            const double here = count ? squares[i] : square_of[j];
            if (j + i < known)
                square_of[j + i] = here;
            if (here > *square) {
                *square = here;
                best = j + i;
            }
        }
        j += either;
    }
    return best;
}

enum { FEW = 128 /* entries of a column that is taken as sparse */ };

/* The entries of v[n] that are not zero into list[FEW]: how many; FEW where they are not so few, or no fewer than half */
static int list_entries(int n, const double *v, int *list)
{
    int count = 0;
    for (int i = 0; i < n && count < FEW; i++)
        if (v[i] != 0.0)
            list[count++] = i;
    return 2 * count < n ? count : FEW;
}

/* Reflect columns k + 1 to `columns` by v, which is column k from row k on. Of mechanisms with many links most entries are zero, and skipped: sums are the same to the bit. */
static void reflect_columns(int n, int columns, int known, double *g, int k, double beta, double *square_of)
{
    double sums[ABREAST];
    int list[FEW];
    const double *v = g + (size_t)k * n + k;
    const int few = list_entries(n - k, v, list);
    for (int j = k + 1; j < columns; j += ABREAST) {
        const int count = columns - j < ABREAST ? columns - j : ABREAST;
        if (few == FEW)
            dots(n - k, count, (size_t)n, v, g + (size_t)j * n + k, sums);
        for (int i = 0; i < count; i++) {
            double *x = g + (size_t)(j + i) * n + k;
            if (few < FEW) {
                sums[i] = 0.0;
                for (int l = 0; l < few; l++)
                    sums[i] += v[list[l]] * x[list[l]];
                for (int l = 0; l < few && sums[i] != 0.0; l++)
                    x[list[l]] -= beta * sums[i] * v[list[l]];
            } else
                subtract(n - k, beta * sums[i], v, x);
            if (j + i < known && (sums[i] != 0.0 || x[0] != 0.0)) /* the next do not count row k */
                square_of[j + i] = -1.0;
        }
    }
}

/* Swap columns k and `best`, with what is known of them */
static void swap_columns(int n, double *g, int k, int best, int known, double *square_of, int *order)
{
    for (int i = 0; i < n; i++) {
        const double swap = g[(size_t)k * n + i];
        g[(size_t)k * n + i] = g[(size_t)best * n + i];
        g[(size_t)best * n + i] = swap;
    }
    if (best < known)
        square_of[best] = square_of[k];
    const int swap = order[k];
    order[k] = order[best];
    order[best] = swap;
}

int reduce_columns(int n, int columns, double *g, double nearest, double *diagonal, double *beta, int *order)
{
    const int most = n < columns ? n : columns;
    double first = 0.0, *square_of = diagonal; /* of columns that are not reduced yet */
    for (int j = 0; j < most; j++)
        square_of[j] = -1.0;
    for (int k = 0; k < most; k++) {
        double length;
        const int best = longest(n, order ? columns : k + 1, most, g, k, square_of, &length);
        length = sqrt(length);
        if (k == 0)
            first = length;
        if (!(length > nearest * first) || length == 0.0)
            return k;
        if (best != k)
            swap_columns(n, g, k, best, most, square_of, order);
        double *v = g + (size_t)k * n;
        diagonal[k] = v[k] > 0.0 ? -length : length;
        v[k] -= diagonal[k];
        beta[k] = 2.0 / dot(n - k, v + k, v + k);
        reflect_columns(n, columns, most, g, k, beta[k], square_of);
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
