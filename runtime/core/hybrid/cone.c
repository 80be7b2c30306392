/* Where a row of the closure is lost, lambda . A = 0, the loop can go on along velocities with
 *
 *     chi(u) = lambda . A_dot(q, u) u = 0
 *
 * alone (docs/theory, eq. 8.4): a cone. What drives prescribe, or friction leaves, of the velocities behind an impact there need not be on it.
 * The nearest ones by the mass matrix are, u = u0 + Z w with Z the motions that the other rows leave, orthonormal in that metric:
 *
 *     least |w|,  chi(u0 + Z w) = 0,  g0 + G w >= 0
 *
 * for the rates g of the contacts that are closed. For each set of contacts that stay at rest, which are few, this has one multiplier (as trust
 * regions have: J. J. More, D. C. Sorensen, SIAM J. Sci. Stat. Comput. 4, 1983), and the nearest solution is taken that drives no contact in.
 */
#include "hybrid/cone.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "algebra/dot.h"
#include "algebra/orthogonal.h"
#include "base/tolerances.h"
#include "constraints/branch.h"
#include "constraints/nullspace.h"
#include "hybrid/own_impact.h"
#include "impact/impact.h"
#include "model/contacts.h"

enum { SWEEPS = 12, HALVINGS = 60, MOST_CLOSED = 8 /* for 256 sets of them */ };

struct cone {
    int freedom, closed;
    double *Z;            /* [freedom][n] motions, orthonormal by the mass matrix */
    double *lambda;       /* [rows + drives] the row that is lost */
    double *B, *b, c;     /* chi(u0 + Z w) = c + 2 b.w + w.B w */
    double *G, *g0;       /* [closed][freedom], [closed] rates, by the extents of contacts */
    double *bias, *p, *v; /* [rows + drives], [n], [n] scratch */
};

/* chi(u, v): half of what it has for u + v more than for both */
static double chi(const struct system *s, const double *q, const struct cone *k, const double *u, const double *v)
{
    double found = 0.0;
    for (int part = 0; part < 3; part++) {
        for (int i = 0; i < s->n; i++)
            k->v[i] = (part < 2 ? u[i] : 0.0) + (part != 1 ? v[i] : 0.0);
        s->model->closure_bias(s->k, q, k->v, k->bias);
        for (int j = 0; j < s->model->rows; j++)
            found += (part ? -0.5 : 0.5) * k->lambda[j] * k->bias[j];
    }
    return found;
}

/* 0, or 1 where there is no cone: where no row is lost, more than one is, or that of a driven joint, too many contacts are closed, or memory runs out */
static int take_cone(struct phase *f, struct cone *k)
{
    struct system *s = f->s;
    const size_t n = s->n, contacts = s->model->contacts, rows = s->model->rows;
    k->Z = TAKE(s->arena, double, n *n);
    k->lambda = TAKE(s->arena, double, rows + s->model->drives);
    k->bias = TAKE(s->arena, double, rows + s->model->drives);
    k->B = TAKE(s->arena, double, n *n);
    k->b = TAKE(s->arena, double, n);
    k->G = TAKE(s->arena, double, contacts *n);
    k->g0 = TAKE(s->arena, double, contacts);
    k->p = TAKE(s->arena, double, n);
    k->v = TAKE(s->arena, double, n);
    if (s->arena->ran_out || !left_null_vector(s, f->y, 0, k->lambda) || left_null_vector(s, f->y, 1, k->bias))
        return 1;
    for (int d = 0; d < s->model->drives; d++) /* what drives prescribe there changes with time */
        if (fabs(k->lambda[rows + d]) > RANK_TOLERANCE_PROJECTED)
            return 1;
    const int rank = free_motions(s, f->y, k->Z);
    k->freedom = rank < 0 ? 0 : s->n - rank;
    k->closed = 0;
    contact_gaps(s, f->y, f->gaps);
    for (int c = 0; c < s->model->contacts; c++)
        if (f->gaps[c] <= SHUT * s->extent[c])
            f->set[k->closed++] = c;
    return !k->freedom || k->closed > MOST_CLOSED;
}

/* Make the motions orthonormal by the mass matrix (Gram and Schmidt, twice). */
static void orthonormalise(const struct system *s, const double *q, const struct cone *k)
{
    for (int j = 0; j < k->freedom; j++) {
        double *z = k->Z + (size_t)j * s->n;
        for (int pass = 0; pass < 2; pass++)
            for (int i = 0; i < j; i++) {
                const double *other = k->Z + (size_t)i * s->n;
                s->model->momentum(s->k, q, z, k->p);
                const double part = dot(s->n, other, k->p);
                for (int l = 0; l < s->n; l++)
                    z[l] -= part * other[l];
            }
        s->model->momentum(s->k, q, z, k->p);
        const double length = sqrt(dot(s->n, z, k->p));
        for (int l = 0; l < s->n; l++)
            z[l] /= length;
    }
}

static void fill_cone(struct phase *f, struct cone *k)
{
    const struct system *s = f->s;
    const double *u0 = f->y + s->n;
    orthonormalise(s, f->y, k);
    contact_rates(s, f->y, u0, f->rates);
    for (int i = 0; i < k->closed; i++)
        k->g0[i] = f->rates[f->set[i]] / s->extent[f->set[i]];
    for (int j = 0; j < k->freedom; j++) {
        const double *z = k->Z + (size_t)j * s->n;
        k->b[j] = chi(s, f->y, k, u0, z);
        for (int i = 0; i <= j; i++)
            k->B[i * k->freedom + j] = k->B[j * k->freedom + i] = chi(s, f->y, k, k->Z + (size_t)i * s->n, z);
        contact_rates(s, f->y, z, f->rates);
        for (int i = 0; i < k->closed; i++)
            k->G[i * k->freedom + j] = f->rates[f->set[i]] / s->extent[f->set[i]];
    }
}

/* The contacts that stay at rest: their rows factorised as columns, and the least w[freedom] that brings them there */
struct resting {
    int rank;
    double *g, *diagonal, *beta, *least;
};

static int take_resting(struct arena *arena, const struct cone *k, struct resting *r)
{
    const size_t d = k->freedom;
    r->g = TAKE(arena, double, k->closed *d);
    r->diagonal = TAKE(arena, double, k->closed);
    r->beta = TAKE(arena, double, k->closed);
    r->least = TAKE(arena, double, d);
    return arena->ran_out;
}

static void bring_to_rest(const struct cone *k, unsigned rest, struct resting *r)
{
    const int d = k->freedom;
    double right[MOST_CLOSED];
    int order[MOST_CLOSED], held = 0;
    for (int i = 0; i < k->closed; i++)
        if (rest >> i & 1) {
            memcpy(r->g + held * d, k->G + i * d, d * sizeof *r->g);
            order[held] = held;
            right[held++] = -k->g0[i];
        }
    r->rank = reduce_columns(d, held, r->g, RANK_TOLERANCE, r->diagonal, r->beta, order);
    memset(r->least, 0, d * sizeof *r->least);
    for (int i = 0; i < r->rank; i++)
        r->least[i] = right[order[i]];
    solve_transposed_triangle(d, r->rank, r->g, r->diagonal, r->least);
    reflect(d, r->rank, r->g, r->beta, 0, r->least);
}

/* chi(least + Q y) in the directions Q that leave the contacts at rest, turned to where it is a sum: c + sum of 2 b[i] y[i] + mu[i] y[i]^2 */
struct reduced {
    int count;
    double *Q, *R; /* [count][freedom], [count][count] */
    double *mu, *b, c;
};

static int take_reduced(struct arena *arena, const struct cone *k, struct reduced *x)
{
    const size_t d = k->freedom;
    x->Q = TAKE(arena, double, d *d);
    x->R = TAKE(arena, double, d *d);
    x->mu = TAKE(arena, double, d);
    x->b = TAKE(arena, double, d);
    return arena->ran_out;
}

/* b(v, w) of the quadratic part of chi */
static double bent(const struct cone *k, const double *v, const double *w)
{
    double found = 0.0;
    for (int i = 0; i < k->freedom; i++)
        found += v[i] * dot(k->freedom, k->B + (size_t)i * k->freedom, w);
    return found;
}

/* x, y <- cos x + sin y, cos y - sin x, of `count` numbers each `apart` */
static void turn(int count, int apart, double angle, double *x, double *y)
{
    const double c = cos(angle), s = sin(angle);
    for (int l = 0; l < count * apart; l += apart) {
        const double old = x[l];
        x[l] = c * old + s * y[l];
        y[l] = c * y[l] - s * old;
    }
}

/* Turn the directions pair by pair until the quadratic part of chi, R[count][count] in them, is a sum of squares (C. G. J. Jacobi, 1846). */
static void diagonalise(const struct cone *k, struct reduced *x)
{
    const int d = k->freedom, n = x->count;
    double *R = x->R, size = 0.0, off = INFINITY;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            R[i * n + j] = bent(k, x->Q + (size_t)i * d, x->Q + (size_t)j * d);
            size = fmax(size, fabs(R[i * n + j]));
        }
    for (int sweep = 0; sweep < SWEEPS && off > DBL_EPSILON * size; sweep++) {
        off = 0.0;
        for (int i = 0; i < n; i++)
            for (int j = 0; j < i; j++) {
                off = fmax(off, fabs(R[i * n + j]));
                const double angle = 0.5 * atan2(2.0 * R[i * n + j], R[i * n + i] - R[j * n + j]);
                turn(d, 1, angle, x->Q + (size_t)i * d, x->Q + (size_t)j * d);
                turn(n, 1, angle, R + i * n, R + j * n);
                turn(n, n, angle, R + i, R + j);
            }
    }
}

static void reduce(const struct cone *k, const struct resting *r, struct reduced *x)
{
    const int d = k->freedom;
    x->count = d - r->rank;
    for (int i = 0; i < x->count; i++) {
        double *p = x->Q + (size_t)i * d;
        memset(p, 0, d * sizeof *p);
        p[r->rank + i] = 1.0;
        reflect(d, r->rank, r->g, r->beta, 0, p);
    }
    diagonalise(k, x);
    x->c = k->c + 2.0 * dot(d, k->b, r->least) + bent(k, r->least, r->least);
    for (int i = 0; i < x->count; i++) {
        const double *p = x->Q + (size_t)i * d;
        x->mu[i] = bent(k, p, p);
        x->b[i] = dot(d, k->b, p) + bent(k, p, r->least);
    }
}

/* What chi is, times its sign at y = 0, at y[i] = -t b[i] / (1 + t mu[i]), least for their |y| */
static double along(const struct reduced *x, double sign, double t)
{
    double found = sign * x->c;
    for (int i = 0; i < x->count; i++) {
        const double whole = 1.0 + t * sign * x->mu[i];
        found -= x->b[i] * x->b[i] * t * (1.0 + whole) / (whole * whole);
    }
    return found;
}

/* The multiplier in [0, last] at which chi is 0, or -1 where it is not so far */
static double find_multiplier(const struct reduced *x, double sign, double last)
{
    const double square = dot(x->count, x->b, x->b);
    double low = 0.0, high = fmin(sign * x->c / (2.0 * square), last); /* where nothing bends */
    for (int pass = 0; pass < HALVINGS && along(x, sign, high) > 0.0; pass++) {
        if (high == last)
            return -1.0;
        low = high;
        high = fmin(2.0 * high, last);
    }
    if (!(along(x, sign, high) <= 0.0))
        return -1.0;
    for (int pass = 0; pass < HALVINGS; pass++) {
        const double middle = 0.5 * (low + high);
        *(along(x, sign, middle) > 0.0 ? &low : &high) = middle;
    }
    return high;
}

/* y[count], the least with chi = 0; on one of both sides where there are two. Whether there is one: the multiplier t is where all 1 + t mu > 0, in
 * which chi falls, or at the end of that, where the direction that bends most has no part in the gradient. */
static int find_least(const struct reduced *x, double enough, int side, double *y)
{
    memset(y, 0, x->count * sizeof *y);
    if (fabs(x->c) <= enough)
        return side > 0;
    const double sign = x->c < 0.0 ? -1.0 : 1.0;
    int most = 0;
    double size = 0.0;
    for (int i = 0; i < x->count; i++) {
        size = fmax(size, fabs(x->mu[i]));
        most = sign * x->mu[i] < sign * x->mu[most] ? i : most;
    }
    const int ends = x->count && sign * x->mu[most] < -RANK_TOLERANCE * size;
    const double end = ends ? -1.0 / (sign * x->mu[most]) : INFINITY;
    const double t = x->count ? find_multiplier(x, sign, ends ? end * (1.0 - AT_END) : INFINITY) : -1.0;
    double rest = sign * x->c;
    if (t < 0.0 && !ends)
        return 0;
    for (int i = 0; i < x->count; i++) {
        const double whole = 1.0 + (t < 0.0 ? end : t) * sign * x->mu[i]; /* 0 for others that bend as much */
        const int left = t < 0.0 && whole < AT_END;
        y[i] = left ? 0.0 : -(t < 0.0 ? end : t) * sign * x->b[i] / whole;
        rest += sign * y[i] * (2.0 * x->b[i] + x->mu[i] * y[i]);
    }
    if (t < 0.0) {
        const double b = sign * x->b[most], mu = sign * x->mu[most];
        y[most] = (-b + side * sqrt(fmax(b * b - mu * rest, 0.0))) / mu;
    }
    return t < 0.0 || side > 0;
}

/* Whether no closed contact is driven in by w */
static int opens(const struct cone *k, const double *w, double still)
{
    for (int i = 0; i < k->closed; i++)
        if (!(k->g0[i] + dot(k->freedom, k->G + (size_t)i * k->freedom, w) >= -still))
            return 0;
    return 1;
}

/* w[freedom], the nearest velocities on the cone; whether there are some */
static int find_nearest(struct system *s, const struct cone *k, double enough, double *w)
{
    const int d = k->freedom;
    const struct mark mark = s->arena->top;
    struct resting r;
    struct reduced x;
    double *trial = TAKE(s->arena, double, d), *y = TAKE(s->arena, double, d), least = INFINITY;
    const unsigned sets = take_resting(s->arena, k, &r) || take_reduced(s->arena, k, &x) ? 0 : 1u << k->closed;
    for (unsigned rest = 0; rest < sets && !interrupted(s->interruption, s->n); rest++) {
        bring_to_rest(k, rest, &r);
        reduce(k, &r, &x);
        for (int side = -1; side <= 1; side += 2) {
            if (!find_least(&x, enough, side, y))
                continue;
            memcpy(trial, r.least, d * sizeof *trial);
            for (int i = 0; i < x.count; i++)
                for (int l = 0; l < d; l++)
                    trial[l] += y[i] * x.Q[(size_t)i * d + l];
            const double square = dot(d, trial, trial);
            if (opens(k, trial, REST_SPEED / s->time) && square < least) {
                least = square;
                memcpy(w, trial, d * sizeof *w);
            }
        }
    }
    give_back(s->arena, mark);
    return isfinite(least);
}

/* Go on with velocities u[n], which an impact of the loop with itself leaves. */
static enum outcome go_on_with(struct phase *f, const double *u)
{
    struct system *s = f->s;
    const size_t n = s->n;
    const struct mark mark = s->arena->top;
    double *before = TAKE(s->arena, double, s->size), *du = TAKE(s->arena, double, n);
    double *momentum = TAKE(s->arena, double, n);
    enum outcome outcome = s->arena->ran_out ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    if (!outcome) {
        const double loss = jump_loss(s, f->y, f->y + n, u, du, momentum);
        memcpy(before, f->y, s->size * sizeof *before);
        if (s->model->drives || loss > 0.0) {
            memcpy(f->y + n, u, n * sizeof *u);
            outcome = note_own_impact(f, before, loss);
        }
    }
    give_back(s->arena, mark);
    return outcome;
}

enum outcome leave_on_cone(struct phase *f)
{
    struct system *s = f->s;
    const struct mark mark = s->arena->top;
    struct cone k;
    enum outcome outcome = OUTCOME_DONE;
    if (!s->rows_on || !moves(s, f->y + s->n) || take_cone(f, &k))
        goto end;
    const double speed = fastest(s, f->y + s->n), enough = STRAIGHT * speed * speed;
    k.c = chi(s, f->y, &k, f->y + s->n, f->y + s->n);
    if (!(fabs(k.c) > enough))
        goto end;
    fill_cone(f, &k);
    double *w = TAKE(s->arena, double, k.freedom), *u = TAKE(s->arena, double, s->n);
    if (!s->arena->ran_out && find_nearest(s, &k, enough, w)) {
        for (int l = 0; l < s->n; l++) {
            u[l] = f->y[s->n + l];
            for (int j = 0; j < k.freedom; j++)
                u[l] += w[j] * k.Z[(size_t)j * s->n + l];
        }
        outcome = go_on_with(f, u);
    }
end:
    give_back(s->arena, mark);
    return s->arena->has_run_out ? OUTCOME_NO_MEMORY : interrupted(s->interruption, 0) ? OUTCOME_INTERRUPTED : outcome;
}
