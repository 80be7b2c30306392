/* What small differences become along a collocated step (docs/theory, eq. 11.7): the equations are linear, and solved by sweeps as
 * those of the motion are. That is less work than to eliminate, as long as there are not many of them.
 *
 * The numbers of all nodes lie side by side, and every loop over nodes is a vector: of one difference as of many. */
#include "motion/carried.h"

#include <math.h>
#include <string.h>

#include "base/tolerances.h"

enum { SWEEPS = 40, MOST = 8 };   /* sweeps, and columns that go through a step side by side, at most */
static const double STANDS = 1e3; /* times that: what does not fall any more is rounding; else it does not contract */
static const double GROWS = 8.0;  /* times the solution: sweeps that go further on their way lose more than a digit */

/* A step with its derivatives by nodes. Coordinates that accelerations depend on, or on whose rates they do, are `acting` and come
 * first: the others, as the place of what falls freely, feed nothing back, and are found behind the sweeps. */
struct sweeping_step {
    const struct carrying *of;
    int acting;
    int *order, *still;           /* [n] coordinates, those that act first; those that do not */
    double *J;                    /* [n][2 acting][NODES] */
    double once[NODES * NODES];   /* [from][to]: what accelerations at a node add to rates, */
    double twice[NODES * NODES];  /* and to places, at the others */
    double c[NODES], b[2][NODES]; /* c h; weights of the end of the step, of rates and of places */
};

/* Arrays of some columns: [coordinates][side][NODES] */
struct sweeping_room {
    double *right, *w, *next; /* [n] what does not change; accelerations, and those of the next sweep */
    double *kept;             /* [n] accelerations of columns that are done */
    double *place;            /* [2 acting] places, and then rates */
};

/* The tableau by the length of the step */
static void prepare(const struct collocation *g, const struct carrying *step, struct sweeping_step *s)
{
    const double h = step->h;
    for (int k = 0; k < NODES; k++) {
        for (int l = 0; l < NODES; l++) {
            s->once[k * NODES + l] = h * g->A[l * NODES + k];
            s->twice[k * NODES + l] = h * h * g->twice[l * NODES + k];
        }
        s->c[k] = h * g->c[k];
        s->b[0][k] = h * g->b[k];
        s->b[1][k] = h * h * g->twice_b[k];
    }
}

/* Whether the sweeps of a column are done: 1; -1 where they lead nowhere; 0 where they go on. Of changes that fall by a factor, less than a
 * half, what is left are all that follow together. */
static int done(double change, double before, double size)
{
    if (!isfinite(change + size))
        return -1;
    const double rate = change / before, left = rate < 0.5 ? change * rate / (1.0 - rate) : change;
    const int stands = change <= STANDS * CARRIED_CHANGE * size && rate >= 0.5;
    return (isfinite(before) ? left : change) <= CARRIED_CHANGE * size || stands;
}

/* The functions that take most of the time, by the length of vectors: of any processor, and longer ones that are asked for while the
 * program runs. None has a product and a sum rounded at once, so that numbers are the same on all. */
#ifdef __clang__
#pragma STDC FP_CONTRACT OFF
#endif
#define NAMED(name) name##_usual
#define TARGET
#if CCGEN_PRECISION == 0 && defined(__GNUC__)
#define WIDTH 2
#else
#define WIDTH 1
#endif
#include "motion/carried_sweeps.h"

#if CCGEN_PRECISION == 0 && defined(__GNUC__) && defined(__x86_64__)
#define NAMED(name) name##_wide
#define TARGET __attribute__((target("avx2")))
#define WIDTH 4
#include "motion/carried_sweeps.h"

#define NAMED(name) name##_widest
#define TARGET __attribute__((target("avx512f")))
#define WIDTH 8
#include "motion/carried_sweeps.h"

static int carry_all(struct sweeping_step *s, int columns, double *whole, double *room)
{
    if (__builtin_cpu_supports("avx512f"))
        return carry_all_widest(s, columns, whole, room);
    return __builtin_cpu_supports("avx2") ? carry_all_wide(s, columns, whole, room)
                                          : carry_all_usual(s, columns, whole, room);
}
#else
#define carry_all carry_all_usual
#endif

/* y[rows][columns] = matrix[rows][count] x[count][columns], or less that */
static void multiply_whole(int rows, int count, int columns, const double *matrix, const double *x, int less, double *y)
{
    for (int i = 0; i < rows; i++)
        for (int j = 0; j < count; j++)
            for (int l = 0; l < columns; l++) {
                const double one = matrix[(size_t)i * count + j] * x[j * columns + l];
                y[i * columns + l] = less ? y[i * columns + l] - one : j ? y[i * columns + l] + one : one;
            }
}

int carry(const struct collocation *g, const struct carrying *step, int columns, double *whole, double *room)
{
    const int n = step->n;
    double *order = room + (size_t)2 * n * n * NODES, *rest = order + 2 * n;
    struct sweeping_step s = {.of = step, .J = room, .order = (int *)order, .still = (int *)(order + n)};
    prepare(g, step, &s);
    if (!carry_all(&s, columns, whole, rest))
        return 0;
    for (int k = 0; k < step->count; k++) {
        multiply_whole(step->rows[k], step->width, columns, step->moves[k], whole, 0, rest);
        multiply_whole(n, step->rows[k], columns, step->pull[k], rest, 1, whole + step->first[k] * columns);
    }
    return 1;
}

size_t carry_room(const struct carrying *step, int columns)
{
    const size_t n = step->n, sweeps = 6 * n * MOST * NODES;
    size_t most = sweeps;
    for (int k = 0; k < step->count; k++) {
        const size_t missed = (size_t)step->rows[k] * columns;
        most = missed > most ? missed : most;
    }
    return 2 * n * n * NODES + 2 * n + most;
}
