/* Contacts whose gaps no motion can change: the part of their rows that the motions have which loops and driven joints leave. */
#include "constraints/mobility.h"

#include <math.h>
#include <string.h>

#include "algebra/dot.h"
#include "algebra/elimination.h"
#include "algebra/orthogonal.h"
#include "base/tolerances.h"
#include "constraints/nullspace.h"
#include "model/contacts.h"

enum outcome movable_contacts(struct system *s, const double *q, int count, const int *set, char *moves)
{
    const size_t n = s->n, contacts = s->model->contacts;
    const struct mark mark = s->arena->top;
    double *motions = TAKE(s->arena, double, n *n), *motion = TAKE_ZEROS(s->arena, double, n);
    double *rates = TAKE(s->arena, double, contacts);
    double *whole = TAKE_ZEROS(s->arena, double, contacts), *left = TAKE_ZEROS(s->arena, double, contacts);
    const int rank = s->arena->ran_out ? -1 : free_motions(s, q, motions);
    for (size_t i = 0; rank >= 0 && i < n; i++) {
        motion[i] = s->unit[i];
        contact_rates(s, q, motion, rates);
        motion[i] = 0.0;
        for (size_t c = 0; c < contacts; c++)
            whole[c] += rates[c] * rates[c];
    }
    for (size_t j = 0; rank >= 0 && j < n - rank; j++) {
        contact_rates(s, q, motions + j * n, rates);
        for (size_t c = 0; c < contacts; c++)
            left[c] += rates[c] * rates[c];
    }
    for (int i = 0; rank >= 0 && i < count; i++)
        moves[i] = left[set[i]] > RANK_TOLERANCE * RANK_TOLERANCE * whole[set[i]];
    give_back(s->arena, mark);
    return rank < 0 ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
}

/* Rows of contacts, row[size] of the rows of their gaps, then of their sliding, that hang together: each moves another */
struct block {
    int size, *row;
};

int rows_that_move_each_other(int contacts, int rows, const char *holds, const double *W, int first, char *taken,
                              int *row)
{
    int size = 1;
    row[0] = first;
    taken[first] = 1;
    for (int k = 0; k < size; k++) {
        const int i = row[k];
        const double own = W[(size_t)i * (rows + 1)];
        for (int j = 0; j < rows; j++) {
            const double whole = sqrt(fmax(own, 0.0)) * sqrt(fmax(W[(size_t)j * (rows + 1)], 0.0));
            const int moves = j % contacts == i % contacts || fabs(W[(size_t)i * rows + j]) > CONSISTENT * whole;
            if (!holds[j] || taken[j] || !moves)
                continue;
            taken[j] = 1;
            row[size++] = j;
        }
    }
    return size;
}

/* How many rows of the block count where all are of one size: what is left of others is less than what Coulomb's law may be missed by. */
static int rank_of_response(struct arena *arena, int rows, const double *W, const struct block *b)
{
    const struct mark mark = arena->top;
    const int n = b->size;
    double *a = TAKE(arena, double, (size_t)n *n), *x = TAKE_ZEROS(arena, double, n), *root = TAKE(arena, double, n);
    int *order = TAKE(arena, int, n), rank = n;
    for (int i = 0; i < n && !arena->ran_out; i++)
        root[i] = sqrt(fmax(W[(size_t)b->row[i] * (rows + 1)], 0.0));
    for (int i = 0; i < n && !arena->ran_out; i++)
        for (int j = 0; j < n; j++) {
            const double size = root[i] * root[j];
            a[(size_t)i * n + j] = size > 0.0 ? W[(size_t)b->row[i] * rows + b->row[j]] / size : 0.0;
        }
    if (!arena->ran_out)
        rank = eliminate_dependent(n, n, a, x, order, CONSISTENT);
    give_back(arena, mark);
    return rank;
}

/* How many rows of the block count among the motions that are left */
static int rank_of_motions(struct system *s, const double *q, int count, const int *set, const struct block *b)
{
    struct arena *arena = s->arena;
    const size_t n = s->n, contacts = s->model->contacts;
    const int rows = b->size;
    const struct mark mark = arena->top;
    double *motions = TAKE(arena, double, n *n), *rates = TAKE(arena, double, contacts);
    double *slips = TAKE(arena, double, contacts), *g = TAKE(arena, double, rows *n);
    double *diagonal = TAKE(arena, double, rows), *beta = TAKE(arena, double, rows);
    int *order = TAKE(arena, int, rows), rank = arena->ran_out ? -1 : free_motions(s, q, motions);
    const int left = s->n - rank;
    for (int k = 0; rank >= 0 && k < left; k++) {
        contact_rates(s, q, motions + (size_t)k * n, rates);
        if (s->friction)
            s->model->slips(s->k, q, motions + (size_t)k * n, slips);
        for (int i = 0; i < rows; i++)
            g[(size_t)i * left + k] = (b->row[i] < count ? rates : slips)[set[b->row[i] % count]];
    }
    for (int i = 0; rank >= 0 && i < rows; i++) {
        double *row = g + (size_t)i * left, length = sqrt(dot(left, row, row));
        order[i] = i;
        for (int k = 0; k < left; k++)
            row[k] /= length > 0.0 ? length : 1.0;
    }
    rank = rank < 0 ? 0 : reduce_columns(left, rows, g, PLAINLY_INDEPENDENT, diagonal, beta, order);
    give_back(arena, mark);
    return rank;
}

int masses_hide(struct system *s, const double *q, int count, const int *set, const char *holds, const char *asked,
                const double *W)
{
    const int rows = s->friction ? 2 * count : count;
    const struct mark mark = s->arena->top;
    char *taken = TAKE_ZEROS(s->arena, char, rows);
    struct block b = {0, TAKE(s->arena, int, rows)};
    int hidden = -1;
    for (int i = 0; i < rows && hidden < 0 && !s->arena->ran_out; i++) {
        if (!holds[i] || taken[i])
            continue;
        b.size = rows_that_move_each_other(count, rows, holds, W, i, taken, b.row);
        int is_asked = 0;
        for (int k = 0; k < b.size; k++)
            is_asked |= asked[b.row[k] % count];
        const int seen = is_asked ? rank_of_response(s->arena, rows, W, &b) : b.size;
        if (seen < b.size && rank_of_motions(s, q, count, set, &b) > seen)
            hidden = i % count;
    }
    give_back(s->arena, mark);
    return hidden;
}
