/* A branch of the closure across a place where rows are dependent: through Chebyshev points of a ray y + x e on both sides of it, at which the closure is well conditioned
 * (docs/theory, eq. 8.10). Where no branch passes the last coefficients of its tangents are large, or the loops do not close at the place.
 */
#include "constraints/ray.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "algebra/chebyshev.h"
#include "base/tolerances.h"
#include "constraints/crossing.h"

enum { ROUNDINGS = 16 };
static const double WIDEST =
    0.1; /* distance from dependence of the outermost nodes; each further try has half of it, */
static const double NARROWEST =
    0.1 / 64; /* down to this, where what the closure tells beside is known to eps / NARROWEST^2, 1e-10 */

void interpolate(const struct system *s, struct branch *b, const double *y, double x)
{
    const int n = s->n, d = b->freedom;
    chebyshev_weights(BRANCH_NODES, x, b->weights);
    struct branch_place *to = &b->last;
    memcpy(to->y, y, d * sizeof *y);
    memset(to->q, 0, n * sizeof *to->q);
    memset(to->T, 0, (size_t)d * n * sizeof *to->T);
    to->margin = fabs(x) * b->half * b->slope;
    for (int k = 0; k < BRANCH_NODES; k++) {
        for (int i = 0; i < n; i++)
            to->q[i] += b->weights[k] * b->nodes[k].q[i];
        for (int i = 0; i < d * n; i++)
            to->T[i] += b->weights[k] * b->nodes[k].T[i];
    }
    b->inside = 1;
}

/* The largest of the last two coefficients of the tangents */
static double last_coefficients(const struct system *s, const struct branch *b)
{
    double most = 0.0, weight[BRANCH_NODES];
    for (int k = BRANCH_NODES - 2; k < BRANCH_NODES; k++) {
        chebyshev_coefficient(BRANCH_NODES, k, weight);
        for (int i = 0; i < b->freedom * s->n; i++) {
            double sum = 0.0;
            for (int j = 0; j < BRANCH_NODES; j++)
                sum += weight[j] * b->nodes[j].T[i];
            most = !(fabs(sum) <= most) ? fabs(sum) : most;
        }
    }
    return most;
}

/* Where rows are dependent along the ray, as part of its half: between the two nodes that are nearest to that */
static double find_middle(const struct branch *b)
{
    double least = INFINITY, found = 0.0;
    for (int k = 0; k + 1 < BRANCH_NODES; k++) {
        const double m = b->nodes[k].margin, next = b->nodes[k + 1].margin;
        if (m + next < least) {
            least = m + next;
            found = (chebyshev_point(BRANCH_NODES, k) * next + chebyshev_point(BRANCH_NODES, k + 1) * m) / least;
        }
    }
    return found;
}

/* The nodes anew, about the place itself, and closed as the configuration there is: where that lies off the branch by e the closure misses by the square of it, as rows are
 * dependent. */
static enum outcome refine_nodes(struct system *s, struct branch *b, struct closed *c)
{
    const int n = s->n, d = b->freedom;
    const struct mark mark = s->arena->top;
    double *guess = TAKE_ZEROS(s->arena, double, (size_t)BRANCH_NODES *n), weight[BRANCH_NODES];
    enum outcome outcome = s->arena->ran_out ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    const double shift = find_middle(b);
    for (int j = 0; j <= BRANCH_NODES && !outcome; j++) {
        chebyshev_weights(BRANCH_NODES, shift + (j < BRANCH_NODES ? chebyshev_point(BRANCH_NODES, j) : 0.0), weight);
        double *to = j < BRANCH_NODES ? guess + (size_t)j * n : b->reference;
        memset(to, 0, n * sizeof *to);
        for (int k = 0; k < BRANCH_NODES; k++)
            for (int i = 0; i < n; i++)
                to[i] += weight[k] * b->nodes[k].q[i];
    }
    for (int i = 0; i < n; i++)
        b->reference[i] *= s->unit[i];
    for (int i = 0; i < d; i++)
        b->middle[i] += shift * b->half * b->ray[i];
    b->referenced = 1;
    for (int k = 0; k < BRANCH_NODES && !outcome; k++) {
        memcpy(b->nodes[k].q, guess + (size_t)k * n, n * sizeof *guess);
        for (int i = 0; i < d; i++)
            b->nodes[k].y[i] = b->middle[i] + b->half * chebyshev_point(BRANCH_NODES, k) * b->ray[i];
        outcome = close_at(s, b, c, &b->nodes[k]);
    }
    give_back(s->arena, mark);
    return outcome;
}

/* The place on one side of the ray through y, as seen from there */
static enum outcome go_aside(struct system *s, struct branch *b, struct closed *c, const struct crossing *x,
                             const double *y, double seen, double side, double *way, struct branch_place *p)
{
    const int d = b->freedom, n = s->n;
    const struct mark mark = s->arena->top;
    struct branch_place to;
    enum outcome outcome = take_place(s->arena, n, &to) ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    b->referenced = 0;
    if (!outcome) {
        for (int i = 0; i < d; i++)
            to.y[i] = b->known.y[i] + (x->place + side) * x->e[i];
        predict(n, d, &b->known, &to);
        outcome = close_at(s, b, c, &to);
    }
    for (int i = 0; i < d && !outcome; i++)
        way[i] = y[i] + (seen + side) * x->e[i] - to.y[i];
    outcome = outcome ? outcome : go_along(s, b, c, &to, way);
    if (!outcome)
        copy_place(s, b, &to, p);
    give_back(s->arena, mark);
    return outcome;
}

/* Whether the loops close where rows are dependent, to rounding: what they miss there along the rows that are lost no nearby configuration makes good, and the branches do not meet. */
static int closes_at_reference(struct system *s, const struct branch *b, struct closed *c)
{
    const int n = s->n, rows = s->model->rows;
    const struct mark mark = s->arena->top;
    double *q = TAKE(s->arena, double, n), *gap = TAKE(s->arena, double, rows);
    struct lost l;
    int closes = 0;
    if (s->arena->ran_out)
        goto end;
    for (int i = 0; i < n; i++)
        q[i] = b->reference[i] / s->unit[i];
    if (factorise_closure(s, b, q, c) || find_lost(s, b, c, &l))
        goto end;
    s->model->closure(s->k, b->reference, gap);
    closes = 1;
    for (int a = 0; a < l.count; a++)
        closes &= lost_row_closes(s, c, &l, a, gap);
end:
    give_back(s->arena, mark);
    return closes;
}

/* The nodes of a ray through y with the outermost `width` from dependence, and what their last coefficients are: *miss, infinite where they are not found */
static enum outcome sample(struct system *s, struct branch *b, struct closed *c, struct crossing *x, const double *y,
                           double width, double *miss)
{
    const int n = s->n, d = b->freedom;
    const struct mark mark = s->arena->top;
    struct branch_place ends[2];
    take_place(s->arena, n, &ends[0]);
    take_place(s->arena, n, &ends[1]);
    double *way = TAKE(s->arena, double, d), half = width / x->slope, seen = x->place;
    enum outcome outcome = s->arena->ran_out ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    *miss = INFINITY;
    for (int i = 0; i < d; i++)
        seen -= x->e[i] * (y[i] - b->known.y[i]);
    for (int k = 0; k < 2 && !outcome; k++)
        outcome = go_aside(s, b, c, x, y, seen, k ? -half : half, way, &ends[k]);
    if (outcome)
        goto end;
    const double sum = ends[0].margin + ends[1].margin, shift = half * (ends[1].margin - ends[0].margin) / sum;
    if (!(fabs(shift) < 0.9 * half))
        goto end;
    seen += shift;
    b->half = half;
    b->slope = sum / (2.0 * half);
    memcpy(b->ray, x->e, d * sizeof *b->ray);
    for (int i = 0; i < d; i++)
        b->middle[i] = y[i] + seen * x->e[i];
    for (int k = 0; k < BRANCH_NODES && !outcome; k++) { /* from both ends inwards */
        const int number = k % 2 ? BRANCH_NODES - 1 - k / 2 : k / 2;
        struct branch_place *from = &ends[k % 2], *to = &b->nodes[number];
        for (int i = 0; i < d; i++)
            to->y[i] = b->middle[i] + half * chebyshev_point(BRANCH_NODES, number) * x->e[i];
        predict(n, d, from, to);
        outcome = close_at(s, b, c, to);
        if (!outcome)
            copy_place(s, b, to, from);
    }
    if (!outcome && !(last_coefficients(s, b) < NO_BRANCH))
        goto end;
    outcome = outcome ? outcome : refine_nodes(s, b, c);
    if (!outcome && !closes_at_reference(s, b, c))
        goto end;
    if (!outcome)
        *miss = last_coefficients(s, b);
end:
    give_back(s->arena, mark);
    return outcome == OUTCOME_NOT_CLOSED ? OUTCOME_DONE : outcome;
}

double along_ray(const struct branch *b, const double *y)
{
    double sum = 0.0;
    for (int i = 0; i < b->freedom; i++)
        sum += b->ray[i] * (y[i] - b->middle[i]);
    return sum;
}

enum outcome bridge(struct system *s, struct branch *b, struct closed *c, const double *y)
{
    const int d = b->freedom;
    struct crossing x = {.e = TAKE(s->arena, double, d)};
    double width = b->width > 0.0 ? b->width : WIDEST, miss = INFINITY, best = INFINITY;
    enum outcome outcome = s->arena->ran_out ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    if (!outcome && b->comes_back > 0.0) {
        memcpy(x.e, b->through, d * sizeof *x.e);
        x.place = b->until;
        for (int i = 0; i < d; i++)
            x.place -= x.e[i] * b->known.y[i];
        x.slope = b->comes_back;
    } else if (!outcome)
        outcome = find_crossing(s, b, c, &x);
    b->sampled = b->biased = 0;
    for (; !outcome; width *= 0.5) {
        outcome = sample(s, b, c, &x, y, width, &miss);
        const double nearest = width * fabs(chebyshev_point(BRANCH_NODES, BRANCH_NODES / 2));
        if (outcome || miss <= ROUNDINGS * DBL_EPSILON / nearest) /* rounding: on a narrower one that is more */
            break;
        if (miss > best) { /* the wider one was better */
            width *= 2.0;
            outcome = sample(s, b, c, &x, y, width, &miss);
            break;
        }
        if (width <= NARROWEST)
            break;
        best = miss;
    }
    if (outcome)
        return outcome;
    if (!(miss < KNOWN_ALONG))
        return OUTCOME_NOT_CLOSED;
    b->sampled = 1;
    b->width = width;
    const double at = along_ray(b, y);
    copy_place(s, b, &b->nodes[at > 0.0 ? 0 : BRANCH_NODES - 1], &b->known);
    if (fabs(at) < b->half) {
        interpolate(s, b, y, at / b->half);
        return OUTCOME_DONE;
    }
    for (int i = 0; i < d; i++)
        b->last.y[i] = y[i] - b->known.y[i];
    struct branch_place to = b->known;
    outcome = go_along(s, b, c, &to, b->last.y);
    b->known.margin = to.margin;
    if (!outcome)
        copy_place(s, b, &b->known, &b->last);
    b->inside = 0;
    return outcome;
}
