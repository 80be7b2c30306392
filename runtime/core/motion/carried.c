/* What small differences become along a collocated step (docs/theory, eq. 11.7), some side by side: the equations are linear, and
 * solved by sweeps as those of the motion are. That is less work than to eliminate, as long as there are few of them. */
#include "motion/carried.h"

#include <math.h>
#include <string.h>

#include "algebra/dot.h"
#include "base/tolerances.h"

enum { SWEEPS = 40 };
static const double STANDS = 1e3; /* times that: what does not fall any more is rounding; else it does not contract */
static const double GROWS = 8.0;  /* times the solution: sweeps that go further on their way lose more than a digit */

/* Arrays of differences have `side` of them side by side, a number that the compiler knows: the loops over it are vectors. */
#define INLINE inline __attribute__((always_inline))

/* The largest numbers of x[count][side], or of its differences to `less` */
static INLINE void largest(int side, size_t count, const double *x, const double *less, double *found)
{
    for (int l = 0; l < side; l++)
        found[l] = 0.0;
    for (size_t i = 0; i < count; i++)
        for (int l = 0; l < side; l++) {
            const double other = less ? less[i * side + l] : 0.0, size = fabs(x[i * side + l] - other);
            found[l] = size > found[l] ? size : found[l];
        }
}

/* y[rows][side] = matrix[rows][count] x[count][side], rows of the matrix `stride` apart. Four rows are summed at a time:
 * the terms of one wait for each other, those of different ones do not. */
static INLINE void multiply(int side, int rows, int count, size_t stride, const double *matrix, const double *x,
                            double *y)
{
    int i = 0;
    for (; i + 4 <= rows && side > 1; i += 4) {
        const double *m0 = matrix + i * stride, *m1 = m0 + stride, *m2 = m1 + stride, *m3 = m2 + stride;
        double sum[4][COLUMNS] = {{0.0}};
        for (int j = 0; j < count; j++)
            for (int l = 0; l < side; l++) {
                sum[0][l] += m0[j] * x[j * side + l];
                sum[1][l] += m1[j] * x[j * side + l];
                sum[2][l] += m2[j] * x[j * side + l];
                sum[3][l] += m3[j] * x[j * side + l];
            }
        memcpy(y + i * side, sum, sizeof sum);
    }
    if (side == 1)
        dots(count, rows, stride, x, matrix, y);
    for (; i < rows && side > 1; i++) {
        double sum[COLUMNS] = {0.0};
        for (int j = 0; j < count; j++)
            for (int l = 0; l < side; l++)
                sum[l] += matrix[i * stride + j] * x[j * side + l];
        memcpy(y + i * side, sum, sizeof sum);
    }
}

/* place[stages][2 n][side]: what accelerations w[stages][n][side] add to places and rates at the nodes */
static INLINE void integrate(int side, const struct collocation *g, int n, double h, const double *w, double *place)
{
    const int all = n * side;
    memset(place, 0, (size_t)2 * g->stages * all * sizeof *place);
    for (int j = 0; j < g->stages; j++)
        for (int l = 0; l < g->stages; l++) {
            const double twice = h * h * g->twice[j * g->stages + l], once = h * g->A[j * g->stages + l];
            double *to = place + (size_t)2 * j * all;
            for (int i = 0; i < all; i++) {
                to[i] += twice * w[l * all + i];
                to[all + i] += once * w[l * all + i];
            }
        }
}

/* Whether sweeps are done: 1; -1 where they lead nowhere; 0 where they go on */
static INLINE int done(int side, const double *change, const double *before, const double *size)
{
    int all = 1;
    for (int l = 0; l < side; l++) {
        if (!isfinite(change[l] + size[l]))
            return -1;
        const int stands = change[l] <= STANDS * CARRIED_CHANGE * size[l] && change[l] >= 0.5 * before[l];
        all &= change[l] <= CARRIED_CHANGE * size[l] || stands;
    }
    return all;
}

/* w[stages][n][side] with w = right + J integrals of w; 0 where sweeps do not find it */
static INLINE int sweep(int side, const struct collocation *g, const struct carrying *step, const double *right,
                        double *w, double *next, double *place)
{
    const int n = step->n;
    const size_t all = (size_t)g->stages * n;
    double change[COLUMNS], before[COLUMNS], most[COLUMNS], size[COLUMNS];
    largest(side, all, right, NULL, most);
    for (int l = 0; l < side; l++)
        before[l] = INFINITY;
    memcpy(w, right, all * side * sizeof *w);
    for (int k = 0, state = 0; k < SWEEPS; k++) {
        integrate(side, g, n, step->h, w, place);
        for (int j = 0; j < g->stages; j++)
            multiply(side, n, 2 * n, step->width, step->J + (size_t)j * n * step->width,
                     place + (size_t)2 * j * n * side, next + (size_t)j * n * side);
        for (size_t i = 0; i < all * side; i++)
            next[i] += right[i];
        largest(side, all, next, w, change);
        largest(side, all, next, NULL, size);
        memcpy(w, next, all * side * sizeof *w);
        state = done(side, change, before, size);
        for (int l = 0; l < side; l++) {
            most[l] = fmax(most[l], size[l]);
            before[l] = change[l];
            if (state > 0 && most[l] > GROWS * size[l])
                return 0;
        }
        if (state)
            return state > 0;
    }
    return 0;
}

/* Put the end of a step back */
static INLINE void put_back(int side, const struct carrying *step, double *whole, double *missed, double *less)
{
    for (int k = 0; k < step->count; k++) {
        const int rows = step->rows[k];
        double *part = whole + step->first[k] * side;
        multiply(side, rows, step->width, step->width, step->moves[k], whole, missed);
        multiply(side, step->n, rows, rows, step->pull[k], missed, less);
        for (int i = 0; i < step->n * side; i++)
            part[i] -= less[i];
    }
}

static INLINE int carry_some(int side, const struct collocation *g, const struct carrying *step, double *whole,
                             double *room)
{
    const int n = step->n, width = step->width;
    const size_t all = (size_t)g->stages * n * side;
    const double h = step->h;
    double *right = room, *w = right + all, *next = w + all, *place = next + all, *at = place + 2 * all;
    memcpy(at, whole, (size_t)width * side * sizeof *at);
    for (int j = 0; j < g->stages; j++) {
        for (int i = 0; i < n * side; i++)
            at[i] = whole[i] + h * g->c[j] * whole[n * side + i];
        multiply(side, n, width, width, step->J + (size_t)j * n * width, at, right + (size_t)j * n * side);
    }
    if (!sweep(side, g, step, right, w, next, place))
        return 0;
    for (int i = 0; i < n * side; i++) {
        double twice = 0.0, once = 0.0;
        for (int j = 0; j < g->stages; j++) {
            twice += g->twice_b[j] * w[j * n * side + i];
            once += g->b[j] * w[j * n * side + i];
        }
        whole[i] += h * whole[n * side + i] + h * h * twice;
        whole[n * side + i] += h * once;
    }
    put_back(side, step, whole, at, right);
    return 1;
}

int carry(const struct collocation *g, const struct carrying *step, int side, double *whole, double *room)
{
    return side == 1 ? carry_some(1, g, step, whole, room) : carry_some(COLUMNS, g, step, whole, room);
}
