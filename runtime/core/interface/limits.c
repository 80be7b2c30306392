/* Accelerations and forces where closure rows are dependent (docs/theory, section 8).
 *
 * At the distance sigma from dependence accelerations are known to rounding / sigma^3, and where rows are dependent the equations leave them open.
 * Along the branch on which the motion passes the place they are analytic all the same, and so are forces, but for a simple pole where joints have to
 * carry without bound. So states on both sides of the place are evaluated, far enough from it, and what holds at it is interpolated through them, at
 * Chebyshev points (J.-P. Berrut, L. N. Trefethen, SIAM Review 46, 2004). The states are those of a ray q + s u: put onto the closure, which is
 * well conditioned there, with the velocities u put onto its rows (eq. 8.6). A ray off the branch, and a place that no branch passes, show in the last Chebyshev
 * coefficients, or in that the state itself is not met.
 *
 * The pole x* of an entry v is where the last coefficient of (x - x*) v vanishes, which is analytic (eq. 8.7).
 */
#include "interface/limits.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "base/tolerances.h"
#include "constraints/nullspace.h"
#include "motion/projection.h"

enum { NODES = 12, TRIES = 3, DOUBLINGS = 5 };
static const double WIDEST = 0.1; /* distance from dependence of the outermost states; each try has half of it */
static const double FIRST = 0.01; /* how far along the ray the place is looked for at first, as part of a radian */
static const double RISES = 1.5;  /* times as far from dependence as the state: both sides of the place are seen */

/* A ray through a state, and the place at which rows are dependent */
struct ray {
    struct system free_; /* the system, without held contacts */
    const double *q, *u; /* [n] */
    double *along;       /* [n] in units */
    double place, slope; /* of the place along the ray, and of the distance from dependence by that */
    int rank;
    double margin;             /* of the state itself */
    double *q_there, *u_there; /* [n] the state last asked for */
};

/* The state at s of the ray; whether it is closed, and how near to dependence rows are there */
static int go_along(struct ray *r, double s, double *margin)
{
    const int n = r->free_.n;
    for (int i = 0; i < n; i++) {
        r->q_there[i] = r->q[i] + s * r->along[i];
        r->u_there[i] = r->u[i];
    }
    if (project_position(&r->free_, r->q_there) || project_velocity(&r->free_, r->q_there, r->u_there))
        return 0;
    const int rank = row_rank(&r->free_, r->q_there, margin);
    if (rank < r->rank)
        *margin = 0.0;
    r->rank = rank > r->rank ? rank : r->rank;
    return 1;
}

/* Whether rows of the state are dependent, or nearly so, and not all along the ray; the place is where they are. */
static int find_place(struct ray *r)
{
    double here, before, behind;
    const int rank = row_rank(&r->free_, r->q, &here);
    r->rank = rank;
    double h = FIRST;
    for (int k = 0; k < DOUBLINGS; k++, h *= 2.0) {
        if (!go_along(r, -h, &before) || !go_along(r, h, &behind))
            return 0;
        const double own = rank < r->rank ? 0.0 : here;
        if (!(own < BESIDE_PLACE))
            return 0;
        if (!(fmin(before, behind) > RISES * own))
            continue;
        r->margin = own;
        r->slope = (before + behind) / (2.0 * h);
        r->place = h * (before - behind) / (before + behind);
        return 1;
    }
    return 0;
}

/* The Chebyshev points are the cosines of these. */
static double angle(int i)
{
    return (2 * i + 1) * acos(0.0) / NODES;
}

static double node(int i)
{
    return cos(angle(i));
}

/* Chebyshev coefficient number k of v at the nodes, or with `times` of x v; v[i * stride] */
static double coefficient(const double *v, size_t stride, int k, int times)
{
    double sum = 0.0;
    for (int i = 0; i < NODES; i++)
        sum += v[i * stride] * (times ? node(i) : 1.0) * cos(k * angle(i));
    return 2.0 * sum / NODES;
}

/* Value at x of the polynomial through (node - pole) v, or through v where there is no pole (NAN) */
static double interpolated(const double *v, size_t stride, double pole, double x)
{
    double above = 0.0, below = 0.0;
    for (int i = 0; i < NODES; i++) {
        const double value = v[i * stride] * (isnan(pole) ? 1.0 : node(i) - pole);
        if (x == node(i))
            return value;
        const double weight = (i % 2 ? -1.0 : 1.0) * sin(angle(i)) / (x - node(i));
        above += weight * value;
        below += weight;
    }
    return above / below;
}

/* What the last coefficients of v are, or with a pole of (x - pole) v */
static double tail(const double *v, size_t stride, double pole)
{
    double most = 0.0;
    for (int k = NODES - 2; k < NODES; k++) {
        const double plain = coefficient(v, stride, k, 0);
        most = fmax(most, fabs(isnan(pole) ? plain : coefficient(v, stride, k, 1) - pole * plain));
    }
    return most;
}

static double largest(const double *v, size_t stride, int count)
{
    double most = 0.0;
    for (int i = 0; i < NODES; i++)
        for (int j = 0; j < count; j++)
            most = fmax(most, fabs(v[i * stride + j]));
    return most;
}

/* The pole of the entry whose last coefficients are the largest; NAN where those of all are small */
static double pole_of(const double *v, size_t stride, int count, double scale)
{
    double pole = NAN, most = SMOOTH * scale;
    for (int j = 0; j < count; j++)
        if (tail(v + j, stride, NAN) > most) {
            most = tail(v + j, stride, NAN);
            pole = coefficient(v + j, stride, NODES - 1, 1) / coefficient(v + j, stride, NODES - 1, 0);
        }
    return pole;
}

/* At how many nodes v is no number */
static int count_unset(const double *v, size_t stride)
{
    int count = 0;
    for (int i = 0; i < NODES; i++)
        count += isnan(v[i * stride]) != 0;
    return count;
}

/* out[count] at x, the state's place among the nodes, from v[NODES][stride], each through its values or, where it has one, with the pole that some
 * may have; what the last coefficients are then, as part of the largest. `half` is what a part of the ray is long. */
static double interpolate_group(const double *v, size_t stride, struct group group, double x, double half, double *out)
{
    const double scale = fmax(largest(v, stride, group.count), group.usual);
    if (!isfinite(scale))
        return INFINITY;
    const double some = group.unbounded ? pole_of(v, stride, group.count, scale) : NAN;
    double worst = 0.0;
    for (int j = 0; j < group.count; j++) {
        const int unset = count_unset(v + j, stride);
        if (unset) { /* not set along the whole ray, or lost on it */
            out[j] = NAN;
            worst = unset < NODES ? INFINITY : worst;
            continue;
        }
        const double *own = v + j, residue = isnan(some) ? 0.0 : interpolated(own, stride, some, some);
        const double pole = fabs(residue) > SMOOTH * scale ? some : NAN;
        if (isnan(pole))
            out[j] = interpolated(own, stride, NAN, x);
        else if (fabs(x - pole) * half > sqrt(DBL_EPSILON)) /* places beside it are known to that */
            out[j] = interpolated(own, stride, pole, x) / (x - pole);
        else
            out[j] = copysign(INFINITY, residue);
        worst = fmax(worst, tail(own, stride, pole));
    }
    return worst > 0.0 ? worst / scale : 0.0;
}

/* Whether the ray through states v[NODES][stride] meets the state itself */
static int meets(const struct ray *r, const double *v, size_t stride, double x)
{
    const int n = r->free_.n;
    double speed = 0.0, missed = 0.0, missed_speed = 0.0;
    for (int i = 0; i < n; i++) {
        const double *unit = r->free_.unit;
        speed = fmax(speed, fabs(r->u[i]) / unit[n + i]);
        missed = fmax(missed, fabs(interpolated(v + i, stride, NAN, x) - r->q[i]) / unit[i]);
        missed_speed = fmax(missed_speed, fabs(interpolated(v + n + i, stride, NAN, x) - r->u[i]) / unit[n + i]);
    }
    const double known = fmax(MEETS, ACROSS_KNOWN * DBL_EPSILON / (r->margin * r->margin)); /* of velocities */
    return missed <= MEETS && missed_speed <= fmin(sqrt(MEETS), known) * speed;
}

/* With the outermost states so far from dependence: what the last coefficients are at most, as part of the largest, infinite where the ray does not lie on a
 * branch; v[NODES][stride] is scratch. */
static enum outcome try_width(struct ray *r, double width, const struct group *groups, int count, evaluation *evaluate,
                              void *context, size_t stride, double *v, double *miss, double *out)
{
    const int n = r->free_.n;
    const double half = width / r->slope, x = -r->place / half;
    double margin, worst = 0.0;
    *miss = INFINITY;
    if (!(fabs(x) <= 0.5)) /* it would lie outside of the states, or at the end of them */
        return OUTCOME_DONE;
    for (int i = 0; i < NODES; i++) {
        double *to = v + i * stride;
        if (!go_along(r, r->place + half * node(i), &margin))
            return OUTCOME_DONE;
        memcpy(to, r->q_there, n * sizeof *to);
        memcpy(to + n, r->u_there, n * sizeof *to);
        const enum outcome outcome = evaluate(context, r->q_there, r->u_there, to + 2 * n);
        if (outcome)
            return outcome == OUTCOME_INTERRUPTED || outcome == OUTCOME_NO_MEMORY ? outcome : OUTCOME_DONE;
    }
    if (!meets(r, v, stride, x))
        return OUTCOME_DONE;
    size_t at = 2 * (size_t)n;
    for (int g = 0; g < count; g++) {
        worst = fmax(worst, interpolate_group(v + at, stride, groups[g], x, half, out + at - 2 * n));
        at += groups[g].count;
    }
    *miss = worst;
    return OUTCOME_DONE;
}

int near_a_limit(struct system *s, const double *q, int rank)
{
    const int rows = s->rows_on + s->model->drives;
    double margin;
    if (!s->rows_on)
        return 0;
    const int own = row_rank(s, q, &margin);
    return margin < BESIDE_PLACE || (own < rows && own != rank);
}

enum outcome limit_along_branch(struct system *s, const double *q, const double *u, const struct group *groups,
                                int count, evaluation *evaluate, void *context, int *rank, int *found, double *out)
{
    const struct mark mark = s->arena->top;
    const int n = s->n;
    size_t stride = 2 * (size_t)n;
    double speed = 0.0;
    for (int g = 0; g < count; g++)
        stride += groups[g].count;
    struct ray r = {.free_ = *s,
                    .q = q,
                    .u = u,
                    .along = TAKE(s->arena, double, n),
                    .q_there = TAKE(s->arena, double, n),
                    .u_there = TAKE(s->arena, double, n)};
    double *v = TAKE(s->arena, double, NODES *stride), *trial = TAKE(s->arena, double, stride);
    enum outcome outcome = s->arena->ran_out ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    *found = 0;
    if (outcome)
        goto end;
    r.free_.active = NULL;
    for (int i = 0; i < n; i++)
        speed = fmax(speed, fabs(u[i]) / s->unit[i]);
    for (int i = 0; i < n; i++)
        r.along[i] = u[i] / speed;
    if (!(speed > 0.0) || !find_place(&r))
        goto end;
    double width = WIDEST, least = SMOOTH, miss;
    for (int k = 0; k < TRIES && !outcome; k++, width *= 0.5) {
        outcome = try_width(&r, width, groups, count, evaluate, context, stride, v, &miss, trial);
        if (!(miss < least))
            continue;
        least = miss;
        *found = 1;
        memcpy(out, trial, (stride - 2 * n) * sizeof *out);
    }
end:
    *rank = r.rank > *rank ? r.rank : *rank;
    give_back(s->arena, mark);
    return outcome;
}
