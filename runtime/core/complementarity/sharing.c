/* Where more contacts push than the mechanism has motions that they could hinder, rigid bodies leave their forces open (docs/theory, section 5.10).
 *
 * Of all forces P that give the same accelerations, P = P0 + Z y with W Z = 0, those of least norm that keep Coulomb's law are the point of a polyhedron
 * that is nearest to the origin: least |y| with G (P0 + Z y) >= 0, P0 being perpendicular to Z. That is a problem of nonnegative least squares in as many
 * unknowns as there are limits (C. L. Lawson, R. J. Hanson, Solving Least Squares Problems, 1974, chapter 23). The norm is Euclid's of
 * normal forces and friction alike, in N; that of a stop is its moment over its lever.
 *
 * What P keeps as an equation, friction that is what sliding makes it, Z does not see, as it does not see W. Each limit is as wide as P needs it: by what P has lost
 * to rounding. So P is always among the forces of which the nearest is sought, and there is one.
 */
#include "complementarity/sharing.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "algebra/dot.h"
#include "algebra/orthogonal.h"
#include "base/tolerances.h"

enum {
    PASSES = 10,   /* per limit; far more than ever needed */
    ROUNDINGS = 16 /* of a sum over limits */
};

/* Nonnegative least squares: the columns E[limits][m], one for each limit, and what of the last unit vector they do not reach */
struct nearest {
    int m, limits, count;             /* of those that are pressed */
    double *E, *u, *trial, *left;     /* [limits][m], [limits], [limits], [m] */
    double *g, *diagonal, *beta, *to; /* [limits][m], [limits], [limits], [m] */
    int *set;                         /* [limits] */
    char *pressed, *depends;          /* [limits] whether it is, and whether its column is one of those that are */
};

/* Least squares with the columns of the set: trial[count]; 1 where they depend on each other */
static int fit(struct nearest *s)
{
    const size_t m = (size_t)s->m;
    for (int k = 0; k < s->count; k++)
        memcpy(s->g + (size_t)k * m, s->E + (size_t)s->set[k] * m, m * sizeof *s->g);
    if (s->count > s->m || reduce_columns(s->m, s->count, s->g, 0.0, s->diagonal, s->beta, NULL) < s->count)
        return 1;
    memset(s->to, 0, m * sizeof *s->to);
    s->to[m - 1] = 1.0;
    reflect(s->m, s->count, s->g, s->beta, 1, s->to);
    for (int k = s->count - 1; k >= 0; k--) {
        double x = s->to[k];
        for (int j = k + 1; j < s->count; j++)
            x -= s->g[(size_t)j * m + k] * s->trial[j];
        if (!(fabs(s->diagonal[k]) > DEPENDENT_PIVOT))
            return 1;
        s->trial[k] = x / s->diagonal[k];
    }
    return 0;
}

static void look_what_is_left(struct nearest *s)
{
    memset(s->left, 0, (size_t)s->m * sizeof *s->left);
    s->left[s->m - 1] = 1.0;
    for (int i = 0; i < s->limits; i++)
        for (int k = 0; k < s->m; k++)
            s->left[k] -= s->u[i] * s->E[(size_t)i * s->m + k];
}

/* Those of the set whose part would be negative leave it, on the way to what fits. 1 where that does not end */
static int settle(struct nearest *s)
{
    for (int again = 0; again <= s->limits; again++) {
        if (fit(s))
            return 1;
        double part = 1.0;
        for (int k = 0; k < s->count; k++)
            if (s->trial[k] <= 0.0)
                part = fmin(part, s->u[s->set[k]] / (s->u[s->set[k]] - s->trial[k]));
        int kept = 0;
        for (int k = 0; k < s->count; k++) {
            const int i = s->set[k];
            s->u[i] = part < 1.0 ? s->u[i] + part * (s->trial[k] - s->u[i]) : s->trial[k];
            s->pressed[i] = (char)(part == 1.0 || (s->u[i] > 0.0 && s->trial[k] > 0.0) || s->u[i] > DEPENDENT_PIVOT);
            if (s->pressed[i])
                s->set[kept++] = i;
            else
                s->u[i] = 0.0;
        }
        s->count = kept;
        if (part == 1.0)
            return 0;
    }
    return 1;
}

/* The size of the terms whose sum is what is left. Limits that contradict each other by v are pressed by 1 / v, so that rounding leaves eps / v of what is none. */
static double size_of_terms(const struct nearest *s)
{
    double sum = 0.0;
    for (int i = 0; i < s->limits; i++)
        sum += s->u[i] * sqrt(dot(s->m, s->E + (size_t)i * s->m, s->E + (size_t)i * s->m));
    return sum;
}

static int solve_nearest(struct nearest *s)
{
    for (int pass = 0; pass < PASSES * (s->limits + 1); pass++) {
        look_what_is_left(s);
        int enter = -1;
        double most = DEPENDENT_PIVOT;
        for (int i = 0; i < s->limits; i++) {
            const double reach = s->pressed[i] || s->depends[i] ? 0.0 : dot(s->m, s->E + (size_t)i * s->m, s->left);
            if (reach > most) {
                most = reach;
                enter = i;
            }
        }
        if (enter < 0)
            return 0;
        s->set[s->count++] = enter;
        if (fit(s)) {
            s->depends[enter] = 1;
            s->count--;
            continue;
        }
        s->pressed[enter] = 1;
        memset(s->depends, 0, (size_t)s->limits);
        if (settle(s))
            return 1;
    }
    return 1;
}

/* The limits G[limits][rows] of Coulomb's law, each of length 1, as G P >= 0, and the equations F[given][rows] of what friction is, and of what opens; how many limits, and
 * *given equations */
static int write_limits(const struct shared *c, double *G, double *F, int *given)
{
    const size_t rows = (size_t)c->rows;
    const int rough = c->rows > c->n;
    int count = 0, equal = 0;
    for (int i = 0; i < c->n; i++) {
        const double mu = rough ? c->mu[i] : 0.0, length = sqrt(1.0 + mu * mu);
        const int within = mu > 0.0 && !c->leaves[i] && !c->side[i];
        if (c->leaves[i])
            F[(size_t)equal++ * rows + i] = 1.0;
        else if (!within)
            G[(size_t)count++ * rows + i] = 1.0;
        for (int way = -1; within && way <= 1; way += 2, count++) {
            G[(size_t)count * rows + i] = mu / length;
            G[(size_t)count * rows + c->n + i] = way / length;
        }
        if (rough && !within) {
            const double side = c->leaves[i] || !(mu > 0.0) ? 0.0 : c->side[i], whole = hypot(1.0, side * mu);
            F[(size_t)equal * rows + i] = side * mu / whole;
            F[(size_t)equal++ * rows + c->n + i] = 1.0 / whole;
        }
    }
    *given = equal;
    return count;
}

/* P[rows] <- its part that W and the equations F[given][rows] see, and the orthonormal Z[rows - rank][rows] that they do not see; how many. -1 where digits are
 * lost */
static int part_unseen(const struct shared *c, int given, const double *F, double *P, double *Z)
{
    const int n = c->rows, all = n + given;
    struct arena *arena = c->arena;
    double *g = TAKE(arena, double, (size_t)all *n), *diagonal = TAKE(arena, double, all),
           *beta = TAKE(arena, double, all);
    int *order = TAKE(arena, int, all);
    if (arena->ran_out)
        return -1;
    for (int j = 0; j < n; j++) { /* rows of W, of one size, span what it sees */
        const double own = c->W[(size_t)j * n + j], unit = own > 0.0 ? 1.0 / own : 0.0;
        for (int i = 0; i < n; i++)
            g[(size_t)j * n + i] = unit * c->W[(size_t)j * n + i];
    }
    memcpy(g + (size_t)n * n, F, (size_t)given * n * sizeof *g);
    for (int j = 0; j < all; j++)
        order[j] = j;
    const int rank = reduce_columns(n, all, g, DEPENDENT_PIVOT, diagonal, beta, order);
    if (rank && !(fabs(diagonal[rank - 1]) > WELL_PIVOT * fabs(diagonal[0])))
        return -1;
    for (int j = rank; j < n; j++) {
        double *z = Z + (size_t)(j - rank) * n;
        memset(z, 0, (size_t)n * sizeof *z);
        z[j] = 1.0;
        reflect(n, rank, g, beta, 0, z);
        const double along = dot(n, z, P);
        for (int i = 0; i < n; i++)
            P[i] -= along * z[i];
    }
    return n - rank;
}

/* seen[rows] <- the forces of least norm within the limits G[limits][rows], from the part of P that is seen, in units of `scale`. 1 where there are none */
static int go_to_nearest(const struct shared *c, int limits, const double *G, int unseen, const double *Z, double scale,
                         const double *P, double *seen)
{
    struct arena *arena = c->arena;
    const size_t rows = (size_t)c->rows, most = (size_t)limits, m = (size_t)unseen + 1;
    struct nearest s = {.m = unseen + 1,
                        .limits = limits,
                        .E = TAKE(arena, double, most *m),
                        .u = TAKE_ZEROS(arena, double, most),
                        .trial = TAKE(arena, double, most),
                        .left = TAKE(arena, double, m),
                        .g = TAKE(arena, double, (most + 1) * m),
                        .diagonal = TAKE(arena, double, most + 1),
                        .beta = TAKE(arena, double, most + 1),
                        .to = TAKE(arena, double, m),
                        .set = TAKE(arena, int, most + 1),
                        .pressed = TAKE_ZEROS(arena, char, most),
                        .depends = TAKE_ZEROS(arena, char, most)};
    if (arena->ran_out)
        return 1;
    for (int i = 0; i < limits; i++) {
        const double *g = G + (size_t)i * rows;
        double *e = s.E + (size_t)i * m;
        for (int k = 0; k < unseen; k++)
            e[k] = dot(c->rows, g, Z + (size_t)k * rows);
        const double least = c->beyond < 0.0 ? fmin(0.0, dot(c->rows, g, P)) : -c->beyond * scale;
        e[unseen] = (least - dot(c->rows, g, seen)) / scale;
    }
    if (solve_nearest(&s) || !(s.left[unseen] > fmax(DEPENDENT_PIVOT, ROUNDINGS * DBL_EPSILON * size_of_terms(&s))))
        return 1;
    for (int k = 0; k < unseen; k++)
        for (size_t i = 0; i < rows; i++)
            seen[i] -= scale * s.left[k] / s.left[unseen] * Z[(size_t)k * rows + i];
    return 0;
}

/* Whether P itself is as far within the limits G[limits][rows] as is asked */
static int is_within(const struct shared *c, int limits, const double *G, double scale, const double *P)
{
    int within = 1;
    for (int i = 0; i < limits && c->beyond >= 0.0; i++)
        within &= dot(c->rows, G + (size_t)i * c->rows, P) >= -c->beyond * scale;
    return within;
}

enum outcome share_forces(const struct shared *c, double *P)
{
    struct arena *arena = c->arena;
    const struct mark mark = arena->top;
    const size_t rows = (size_t)c->rows;
    double *seen = TAKE(arena, double, rows), *Z = TAKE(arena, double, rows *rows);
    double *G = TAKE_ZEROS(arena, double, rows *rows), *F = TAKE_ZEROS(arena, double, rows *rows);
    double scale = 0.0;
    enum outcome outcome = OUTCOME_DONE;
    for (size_t i = 0; i < rows; i++)
        scale = fmax(scale, fabs(P[i]));
    if (!arena->ran_out && scale > 0.0) {
        int given;
        const int limits = write_limits(c, G, F, &given);
        memcpy(seen, P, rows * sizeof *P);
        const int unseen = part_unseen(c, given, F, seen, Z);
        if (unseen <= 0)
            outcome = is_within(c, limits, G, scale, P) ? OUTCOME_DONE : OUTCOME_REPEATS;
        else if (go_to_nearest(c, limits, G, unseen, Z, scale, P, seen))
            outcome = OUTCOME_REPEATS;
        else
            memcpy(P, seen, rows * sizeof *P);
    }
    if (arena->ran_out)
        outcome = OUTCOME_NO_MEMORY;
    give_back(arena, mark);
    return outcome;
}
