/* Gauss-Legendre collocation: implicit Runge-Kutta with eight stages, order 16, symmetric, at fixed step symplectic
 * (E. Hairer, C. Lubich, G. Wanner, Geometric Numerical Integration, 2006, sections II.1.3, VIII.6).
 *
 * The accelerations of all stages are found together, in the lanes of the machine, by fixed-point sweeps that start from the
 * stage polynomial of the step before, carried on. Coordinates are double integrals of the accelerations. The state is summed
 * with what rounding took from the sums before. Two things steer the step: the last Legendre coefficients of the stage
 * polynomial and how these shrink, which tell what it misses, and how fast the sweeps contract. Where they do not contract, and while contacts are held, which lanes know nothing of, DOP853 takes the step: it looks
 * at few states, and does not iterate. Along a branch of the closure (branch.c) stages go one by one, each put onto it; for radau too.
 */
#include "constraints/branch.h"
#include "methods/gauss.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

#include "constraints/active_set.h"
#include "motion/derivative.h"
#include "motion/lanes.h"
#include "motion/power.h"

static const double SHORT =
    1e-8; /* times the time, or the characteristic one: shorter steps, as impacts that accumulate leave, go to DOP853 */
static const double WANTED = 0.4;  /* contraction that steps aim at */
static const double MISSED = 0.03; /* of the last coefficients, times their ratio to the first: the error of a step */
static const double CAUTION =
    18.0;                         /* times the error: what the next step is chosen by, for the motion may get quicker */
static const double ROUGH = 0.25; /* of what the end misses: a jump between two stages is at most this part of it,
                                          but for one in ten, over all places of the jump */
static const double ENDS_ALIKE = 1e-9; /* part of a step: one that begins so near to its end goes on from there */
static const double EARLIER = 0.2;     /* the last coefficient but one counts by this part */
static const double TO_ORDER =
    (STAGES + 1) / 2.0; /* pairs of degrees from the last coefficient to the first that the end misses, 2 STAGES */
enum { ESTIMATES = 4, LINE = 8 /* numbers to a line of the cache */ };

/* Lays the arrays out from `at` on, unless it is NULL; returns how many numbers they take. */
static size_t lay_out(struct gauss *g, const struct system *s, double *at)
{
    const size_t n = s->n, size = s->size, rows = size - n, square = STAGES * STAGES;
    const struct {
        double **array;
        size_t count;
    } parts[] = {{&g->f, rows * STAGES},
                 {&g->g, rows * STAGES},
                 {&g->legendre, rows * STAGES},
                 {&g->q, n * STAGES},
                 {&g->u, n * STAGES},
                 {&g->du, rows * STAGES},
                 {&g->time, STAGES},
                 {&g->node, STAGES},
                 {&g->once, square},
                 {&g->twice, square},
                 {&g->matrix, square},
                 {&g->slope, rows},
                 {&g->none, rows},
                 {&g->weight, n},
                 {&g->lost, size},
                 {&g->lost_next, size},
                 {&g->estimate, ESTIMATES * size},
                 {&g->start, size},
                 {&g->miss, size},
                 {&g->one, 3 * n},
                 {&g->dy, size},
                 {&g->dy1, size},
                 {&g->begin, size},
                 {&g->end, size},
                 {&g->other, dop853.scratch(s)},
                 {&g->side, lanes_scratch(s)}};
    size_t total = 0;
    for (size_t i = 0; i < sizeof parts / sizeof *parts; i++) {
        if (at)
            *parts[i].array = at + total;
        total += (parts[i].count + LINE - 1) / LINE * LINE;
    }
    return total;
}

static const size_t HEAD = (sizeof(struct gauss) + sizeof(double) - 1) / sizeof(double);

static size_t gauss_scratch(const struct system *s)
{
    struct gauss g;
    return HEAD + LINE + lay_out(&g, s, NULL);
}

/* The scratch, laid out at its first use. */
static struct gauss *gauss_of(const struct system *s, double *scratch)
{
    struct gauss *g = (struct gauss *)scratch;
    if (!g->f) {
        double *at = scratch + HEAD;
        const size_t odd = (uintptr_t)at / sizeof *at % LINE;
        lay_out(g, s, at + (LINE - odd) % LINE);
        g->n = s->n;
        g->rows = s->size - s->n;
        g->lanes = s->model->lanes;
    }
    return g;
}

static void gauss_restart(double *scratch, int size)
{
    struct gauss *g = (struct gauss *)scratch;
    g->known = g->tried = g->begun = g->ended = 0;
    if (g->f)
        memset(g->lost, 0, size * sizeof *g->lost);
}

/* The last stage polynomial, what rounding took from the state, and the derivatives at the ends */
static size_t gauss_memory(const struct system *s, double *scratch, int put, double *numbers)
{
    const size_t size = s->size, rows = size - s->n;
    enum { T, H, TRIED, KNOWN, BEGUN, ENDED, SCALARS };
    if (!numbers)
        return SCALARS + rows * STAGES + 4 * size;
    struct gauss *g = gauss_of(s, scratch);
    double scalars[SCALARS] = {g->t, g->h, g->tried, g->known, g->begun, g->ended}, *at = numbers;
    const struct {
        double *array;
        size_t count;
    } parts[] = {{scalars, SCALARS}, {g->legendre, rows * STAGES},
                 {g->lost, size},    {g->lost_next, size},
                 {g->begin, size},   {g->end, size}};
    for (size_t i = 0; i < sizeof parts / sizeof *parts; at += parts[i++].count)
        memcpy(put ? parts[i].array : at, put ? at : parts[i].array, parts[i].count * sizeof *at);
    g->t = scalars[T];
    g->h = scalars[H];
    g->tried = scalars[TRIED] != 0.0;
    g->known = scalars[KNOWN] != 0.0;
    g->begun = scalars[BEGUN] != 0.0;
    g->ended = scalars[ENDED] != 0.0;
    return (size_t)(at - numbers);
}

/* The power of what does work but has no potential, at all stages: the last row of g->f. */
static enum outcome power(struct gauss *g, struct system *s, double t, double h, const double *y)
{
    const int n = g->n;
    for (int j = 0; j < STAGES; j++) {
        gauss_stage(g, j, h, y);
        const enum outcome outcome = system_power(s, t + NODE[j] * h, g->one, g->one + n, g->f + n * STAGES + j);
        if (outcome)
            return outcome;
    }
    return OUTCOME_DONE;
}

/* The same, where sweeps have settled along the closure alone, and whether the work has settled too: no projection removes from it what
 * stages still change across the closure. Where drives leave no motion, that is all they change. */
static enum outcome settled_power(struct gauss *g, struct system *s, double t, double h, struct tolerance tolerance,
                                  const double *y, int *settled)
{
    const int n = g->n, at = 2 * n;
    enum outcome outcome = power(g, s, t, h, y);
    if (outcome || !(g->along > 0.0))
        return outcome;
    double *now = g->f, *before = g->g;
    g->f = before;
    outcome = power(g, s, t, h, y);
    g->f = now;
    const double work = h * weighed(WEIGHT, now + n * STAGES), earlier = h * weighed(WEIGHT, before + n * STAGES);
    *settled = fabs(work - earlier) <= g->along * allowed_error(tolerance, at, fabs(y[at]) + fabs(work));
    return outcome;
}

/* sum[0] + sum[1] = y + lost + increment, the first as near as a number can be */
static void add(double y, double lost, double increment, double *sum, double *lost_next)
{
    const double small = increment + lost, whole = y + small, back = whole - y;
    *lost_next = (y - (whole - back)) + (small - back);
    *sum = whole;
}

/* How often a coefficient of degree k shrinks as it has since that two degrees before, up to the first degree that the end of the step misses. By a factor each; but a load that begins
 * within a step, or as a root at its start, leaves coefficients that shrink as a power of the degree, and that is slower. So do all under loads that switch: what is smooth shrinks so fast
 * that the power costs next to nothing. */
static double steps_to_order(const struct system *s, int k)
{
    return s->model->switches ? log(2.0 * STAGES / k) / log((double)k / (k - 2)) : TO_ORDER;
}

/* How the last coefficients would shrink up to the first degree that the end of the step misses, if they went on as they do: g->further, of degree
 * STAGES - 2 (from where it is half a pair more, which is left out) and STAGES - 1. Degrees are compared with those of their own parity, for a motion may be nearly even or odd about the middle of the
 * step. What bends within the step shrinks slowly, and may lie far below the first coefficients. That is asked of loads alone, and not past a
 * singular configuration: stages there are as exact as their places are known, which no shorter step mends. */
static void look_further(struct gauss *g, const struct system *s, struct tolerance tolerance, const double *y,
                         const double *y1)
{
    const int n = g->n;
    double sum[STAGES] = {0.0};
    g->further[0] = g->further[1] = 0.0;
    if (!passes_by(s) && (s->branch || !gauss_has_loads(s)))
        return;
    for (int i = 0; i < g->rows; i++) {
        const double *c = g->legendre + i * STAGES;
        const double scale = allowed_error(tolerance, n + i, fmax(fabs(y[n + i]), fabs(y1[n + i])));
        for (int k = STAGES - 4; k < STAGES; k++)
            sum[k] += (c[k] / scale) * (c[k] / scale);
    }
    for (int k = STAGES - 2; k < STAGES; k++)
        g->further[k - (STAGES - 2)] = sum[k] < sum[k - 2] ? pow(sum[k] / sum[k - 2], 0.5 * steps_to_order(s, k)) : 1.0;
}

/* End of the step, and what the estimates are made of */
static void finish(struct gauss *g, const struct system *s, double h, struct tolerance tolerance, const double *y,
                   double *y1)
{
    const int n = g->n, size = s->size;
    double *last = g->estimate, *earlier = last + size;
    double first = 0.0;
    gauss_pack(g, LEGENDRE, 1.0, g->matrix);
    gauss_combine(g, s, g->matrix, g->f, g->legendre);
    for (int i = 0; i < g->rows; i++) {
        const double *f = g->f + i * STAGES, *c = g->legendre + i * STAGES;
        const int of_u = n + i;
        if (i < n) {
            add(y[i], g->lost[i], g->slope[i] + h * (g->lost[of_u] + h * weighed(WEIGHT2, f)), &y1[i],
                &g->lost_next[i]);
            last[i] = h * h * c[STAGES - 1] * (0.5 / (2 * STAGES - 1));
            earlier[i] = EARLIER * h * h * c[STAGES - 2] * (0.5 / (2 * STAGES - 3));
        }
        add(y[of_u], g->lost[of_u], h * weighed(WEIGHT, f), &y1[of_u], &g->lost_next[of_u]);
        last[of_u] = h * c[STAGES - 1];
        earlier[of_u] = EARLIER * h * c[STAGES - 2];
        const double scale = allowed_error(tolerance, of_u, fmax(fabs(y[of_u]), fabs(y1[of_u])));
        const double size_of = h * (fabs(c[1]) + fabs(c[2]) + fabs(c[3]));
        first += scale > 0.0 ? (size_of / scale) * (size_of / scale) : 0.0;
    }
    g->first = sqrt(first / size);
    look_further(g, s, tolerance, y, y1);
}

/* The step by DOP853. */
static enum outcome replace(struct gauss *g, struct system *s, double t, double h, struct tolerance tolerance,
                            const double *y, double *y1)
{
    g->replaced = 1;
    memset(g->lost_next, 0, s->size * sizeof *g->lost_next);
    const enum outcome outcome = system_derivative(s, t, y, g->dy);
    return outcome ? outcome : dop853.step(s, g->other, t, h, tolerance, y, g->dy, y1);
}

/* What the last step leaves to the next, if it was accepted, or dy, the derivative at y, right after a restart */
static void go_on(struct gauss *g, const struct system *s, double t, const double *dy)
{
    g->fresh = !g->tried || (g->fresh && t == g->t);
    if (!g->tried) {
        memcpy(g->begin, dy, s->size * sizeof *dy);
        g->begun = 1;
    } else if (t != g->t) {
        double *swap = g->lost;
        g->lost = g->lost_next;
        g->lost_next = swap;
        swap = g->begin;
        g->begin = g->end;
        g->end = swap;
        g->begun = g->ended && fabs(t - (g->t + g->h)) <= ENDS_ALIKE * fabs(g->h);
    }
    g->ended = 0;
}

static enum outcome gauss_step(struct system *s, double *scratch, double t, double h, struct tolerance tolerance,
                               const double *y, const double *dy, double *y1)
{
    struct gauss *g = gauss_of(s, scratch);
    go_on(g, s, t, dy);
    int converged = 0;
    enum outcome outcome = OUTCOME_DONE;
    if (!active_count(s) && fabs(h) > SHORT * fmax(fabs(t), s->time))
        outcome = gauss_solve(g, s, t, h, tolerance, y, dy, &converged);
    if (!outcome && converged && s->size > 2 * s->n && !s->branch)
        outcome = settled_power(g, s, t, h, tolerance, y, &converged);
    g->known = g->replaced = 0;
    g->tried = 1;
    g->t = t;
    g->h = h;
    if (outcome == OUTCOME_INTERRUPTED)
        return outcome;
    if (outcome || !converged)
        return replace(g, s, t, h, tolerance, y, y1);
    finish(g, s, h, tolerance, y, y1);
    g->known = 1;
    return tolerance.rtol > 0.0 ? gauss_look_at_ends(g, s, t, h, y, y1) : OUTCOME_DONE;
}

static double *gauss_estimates(double *scratch, int size, int *count)
{
    struct gauss *g = (struct gauss *)scratch;
    *count = ESTIMATES;
    return g->replaced ? dop853.estimates(g->other, size, count) : g->estimate;
}

/* Size of the last coefficients of the step that was taken: what the stage polynomial misses inside of it, in tolerances. `rough` is
 * what the end of the step misses if coefficients go on to shrink as the last do. */
static double last_coefficients(const struct gauss *g, int size, struct tolerance tolerance, const double *y,
                                const double *y1, double *rough)
{
    double sum = 0.0, further = 0.0;
    for (int i = 0; i < size; i++) {
        const double scale = allowed_error(tolerance, i, fmax(fabs(y[i]), fabs(y1[i])));
        const double last = g->estimate[i] / scale, earlier = g->estimate[size + i] / scale;
        const double on = g->further[1] * last, before = g->further[0] / EARLIER * earlier;
        sum += last * last + earlier * earlier;
        further += on * on + before * before;
    }
    *rough = sqrt(further / size);
    return sqrt(sum / size);
}

/* What the stage polynomial misses shrinks as its last coefficients do, and the end of the step sees it only against the
 * motion's own coefficients of that degree, which shrink likewise: the product of the two; where the last shrink more slowly than all,
 * what they become at the first degree that the end misses. Sweeps that contract slowly
 * make the next step shorter. */
static double gauss_measure(const double *scratch, int size, struct tolerance tolerance, const double *y,
                            const double *y1)
{
    const struct gauss *g = (const struct gauss *)scratch;
    if (g->replaced) /* as the error of a method of this order would be */
        return pow(CAUTION * dop853.measure(g->other, size, tolerance, y, y1), (double)ORDER / dop853.order);
    double rough;
    const double size_of = last_coefficients(g, size, tolerance, y, y1, &rough);
    const double ratio = size_of / g->first;
    if (!isfinite(size_of + g->first)) /* a quotient of such numbers may be 0 */
        return INFINITY;
    const double smooth = size_of > 0.0 ? MISSED * size_of * fmin(1.0, ratio) : 0.0;
    const double error = fmax(smooth, ROUGH * rough), cautious = fmax(CAUTION * smooth, rough);
    const double slow = 0.9 * g->contraction / WANTED;
    const double steered =
        fmax(error > 1.0 ? cautious : fmin(1.0, cautious), slow > 0.3 ? fmin(1.0, pow(slow, ORDER)) : 0.0);
    return fmax(steered,
                pow(gauss_unseen(g, size, tolerance, y, y1), ORDER)); /* what is unseen shrinks as the step does */
}

/* state at theta on the stage polynomial that starts at `start` */
static void follow(const struct gauss *g, double theta, double *y)
{
    const int n = g->n;
    const double x = 2.0 * theta - 1.0, h = g->h;
    double p[STAGES + 2] = {1.0, x}, once[STAGES + 1], twice[STAGES];
    for (int k = 1; k < STAGES + 1; k++)
        p[k + 1] = ((2 * k + 1) * x * p[k] - k * p[k - 1]) / (k + 1);
    once[0] = theta;
    for (int k = 1; k <= STAGES; k++) /* integral of P_k(2 s - 1) over s from 0 to theta */
        once[k] = (p[k + 1] - p[k - 1]) / (2.0 * (2 * k + 1));
    twice[0] = 0.5 * theta * theta;
    for (int k = 1; k < STAGES; k++)
        twice[k] = (once[k + 1] - once[k - 1]) / (2.0 * (2 * k + 1));
    for (int i = 0; i < g->rows; i++) {
        const double *c = g->legendre + i * STAGES;
        y[n + i] = g->start[n + i] + h * weighed(once, c);
        if (i < n)
            y[i] = g->start[i] + h * (theta * g->start[n + i] + h * weighed(twice, c));
    }
}

static enum outcome gauss_prepare(struct system *s, double *scratch, double t, double h, const double *y,
                                  const double *dy, const double *y1, const double *dy1)
{
    struct gauss *g = (struct gauss *)scratch;
    (void)dy, (void)dy1;
    if (g->replaced) {
        const enum outcome outcome = system_derivative(s, t + h, y1, g->dy1);
        return outcome ? outcome : dop853.prepare(s, g->other, t, h, y, g->dy, y1, g->dy1);
    }
    memcpy(g->start, y, s->size * sizeof *y);
    memset(g->miss, 0, s->size * sizeof *y);
    follow(g, 1.0, g->miss);
    for (int i = 0; i < s->size; i++)
        g->miss[i] = y1[i] - g->miss[i];
    return OUTCOME_DONE;
}

static void gauss_interpolate(const double *scratch, int size, double theta, double *y)
{
    const struct gauss *g = (const struct gauss *)scratch;
    if (g->replaced) {
        dop853.interpolate(g->other, size, theta, y);
        return;
    }
    follow(g, theta, y);
    for (int i = 0; i < size; i++)
        y[i] += theta * g->miss[i];
}

const struct method gauss = {
    .name = "gauss",
    .order = ORDER,
    .scratch = gauss_scratch,
    .restart = gauss_restart,
    .memory = gauss_memory,
    .step = gauss_step,
    .estimates = gauss_estimates,
    .measure = gauss_measure,
    .prepare = gauss_prepare,
    .interpolate = gauss_interpolate,
};
