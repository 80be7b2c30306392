/* Gauss-Legendre collocation: the accelerations of all stages of a step, by fixed-point sweeps in the lanes of the machine. */
#include "methods/gauss.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "motion/derivative.h"
#include "motion/lanes.h"
#include "motion/projection.h"

static const double REST = 0.01; /* part of the tolerance that sweeps leave */
static const double DOUBT =
    0.2; /* sweeps are not believed to contract faster: a part that does not feed back hides others */
static const double SLOWEST = 0.7;            /* contraction beyond which a step is given up */
static const double STAGNANT = 0.9;           /* sweeps that contract no better have met rounding, if it is near */
static const double STANDING = 0.1;           /* part of the tolerance that they may leave then */
static const double NEAR = 1e4;               /* units of rounding that they may leave */
static const double UNIT = 4.0 * DBL_EPSILON; /* of rounding */
static const double FIRST_LOOK =
    0.1; /* part of a step: where those along a branch first look for accelerations, for the start may be singular */
enum { SWEEPS = 16, SWEEPS_TO_ROUNDING = 60 };

/* matrix[j][i] times `factor`, in blocks of lanes */
void gauss_pack(const struct gauss *g, const double matrix[STAGES][STAGES], double factor, double *packed)
{
    if (g->lanes == STAGES) {
        for (int i = 0; i < STAGES * STAGES; i++)
            packed[i] = factor * matrix[0][i];
        return;
    }
    for (int b = 0; b < STAGES; b += g->lanes)
        for (int j = 0; j < STAGES; j++)
            for (int l = 0; l < g->lanes; l++)
                *packed++ = factor * matrix[j][b + l];
}

/* out[i][STAGES] = sum over j of x[i][j] matrix[j] for all rows */
void gauss_combine(struct gauss *g, const struct system *s, const double *matrix, const double *x, double *out)
{
    const int lanes = g->lanes;
    for (int b = 0; b < STAGES; b += lanes) {
        double *block = lanes == STAGES ? out : g->du;
        s->model->stages(g->rows, STAGES, g->none, g->none, g->node + b, matrix + b * STAGES, x, block);
        for (int i = 0; i < g->rows && block != out; i++)
            memcpy(out + i * STAGES + b, block + i * lanes, lanes * sizeof *block);
    }
}

/* Legendre polynomials of degree 0 .. STAGES - 1 at x, into row[degree * stride] */
static void legendre(double x, double *row, int stride)
{
    row[0] = 1.0;
    row[stride] = x;
    for (int k = 1; k + 1 < STAGES; k++)
        row[(k + 1) * stride] = ((2 * k + 1) * x * row[k * stride] - k * row[(k - 1) * stride]) * (1.0 / (k + 1));
}

/* First guess of the accelerations of a step: the last stage polynomial, carried on or looked into, or the constant `dy`. */
static enum outcome guess(struct gauss *g, struct system *s, double t, double h, const double *y, const double *dy)
{
    const double since = (t - g->t) / g->h, part = h / g->h;
    const int usable = g->known && since > -1e-9 && since < 1.0 + 1e-9 && since + part < 3.0;
    memset(g->f, 0, (size_t)g->rows * STAGES * sizeof *g->f);
    if (!usable && s->branch) {
        for (int i = 0; i < g->n; i++) {
            g->one[i] = y[i] + FIRST_LOOK * h * y[g->n + i];
            g->one[g->n + i] = y[g->n + i];
        }
        const enum outcome outcome = system_derivative(s, t + FIRST_LOOK * h, g->one, g->dy1);
        for (int i = 0; i < g->n; i++)
            for (int j = 0; j < STAGES; j++)
                g->f[i * STAGES + j] = g->dy1[g->n + i];
        return outcome;
    }
    if (!usable) {
        const enum outcome outcome = g->tried ? system_derivative(s, t, y, g->dy) : OUTCOME_DONE;
        if (outcome)
            return outcome;
        if (g->tried)
            dy = g->dy;
        for (int i = 0; i < g->n; i++)
            for (int j = 0; j < STAGES; j++)
                g->f[i * STAGES + j] = dy[g->n + i];
        return OUTCOME_DONE;
    }
    double at[STAGES][STAGES];
    for (int j = 0; j < STAGES; j++)
        legendre(2.0 * (since + part * NODE[j]) - 1.0, &at[0][j], STAGES);
    gauss_pack(g, (const double (*)[STAGES])at, 1.0, g->matrix);
    gauss_combine(g, s, g->matrix, g->legendre, g->f);
    return OUTCOME_DONE;
}

/* Everything that does not change from sweep to sweep. */
static void prepare_sweeps(struct gauss *g, const struct system *s, double h, struct tolerance tolerance,
                           const double *y)
{
    const int n = g->n;
    gauss_pack(g, ONCE, h, g->once);
    gauss_pack(g, TWICE, h * h, g->twice);
    memcpy(g->node, NODE, sizeof NODE);
    const double length = fabs(h); /* steps may go back */
    double speed = 0.0, force = 0.0, angle = 1.0;
    for (int i = 0; i < n; i++) {
        speed = fmax(speed, fabs(y[n + i]) / s->unit[i]);
        force = fmax(force, fabs(g->f[i * STAGES]) / s->unit[i]);
        angle = fmax(angle, s->lengths[i] ? 0.0 : fabs(y[i]));
    }
    const double noise = UNIT * (speed + length * force * angle); /* the last digit of an angle turns forces */
    g->noise = noise;
    g->grain = DBL_MIN;
    for (int i = 0; i < n; i++) {
        const double q = fabs(y[i]), noise_u = noise * s->unit[i], noise_q = UNIT * q + length * noise_u;
        const double scale_u = fmax(allowed_error(tolerance, n + i, fabs(y[n + i])), noise_u);
        const double scale_q = fmax(allowed_error(tolerance, i, q), noise_q);
        g->slope[i] = h * y[n + i];
        g->weight[i] = scale_u > 0.0 ? length * (1.0 / scale_u + 0.5 * length / scale_q) : 0.0;
        g->grain = fmax(g->grain, scale_u > 0.0 ? noise_u / scale_u : 0.0);
    }
}

void gauss_stage(struct gauss *g, int j, double h, const double *y)
{
    const int n = g->n;
    for (int i = 0; i < n; i++) {
        double once = 0.0, twice = 0.0;
        for (int k = 0; k < STAGES; k++) {
            once += ONCE[k][j] * g->f[i * STAGES + k];
            twice += TWICE[k][j] * g->f[i * STAGES + k];
        }
        g->one[i] = y[i] + NODE[j] * g->slope[i] + h * h * twice;
        g->one[n + i] = y[n + i] + h * once;
    }
}

/* One sweep stage by stage, each put onto the closure first */
static enum outcome sweep_along_branch(struct gauss *g, struct system *s, double t, double h, const double *y)
{
    const int n = g->n;
    for (int j = 0; j < STAGES; j++) {
        gauss_stage(g, j, h, y);
        const enum outcome outcome = system_derivative(s, t + NODE[j] * h, g->one, g->dy1);
        if (outcome)
            return outcome;
        for (int i = 0; i < g->rows; i++)
            g->g[i * STAGES + j] = g->dy1[n + i];
    }
    return OUTCOME_DONE;
}

/* One sweep: g->g = accelerations along the motion that g->f gives */
static enum outcome sweep(struct gauss *g, struct system *s, double t, double h, const double *y)
{
    const int n = g->n, lanes = g->lanes;
    if (s->branch)
        return sweep_along_branch(g, s, t, h, y);
    for (int b = 0; b < STAGES; b += lanes) {
        double *block = lanes == STAGES ? g->g : g->du;
        s->model->stages(n, STAGES, y, g->slope, g->node + b, g->twice + b * STAGES, g->f, g->q);
        s->model->stages(n, STAGES, y + n, g->none, g->node + b, g->once + b * STAGES, g->f, g->u);
        for (int l = 0; l < lanes; l++)
            g->time[l] = t + NODE[b + l] * h;
        const enum outcome outcome = system_acceleration_lanes(s, lanes, g->time, g->q, g->u, block, g->side);
        if (outcome)
            return outcome;
        for (int i = 0; i < n && block != g->g; i++)
            memcpy(g->g + i * STAGES + b, block + i * lanes, lanes * sizeof *block);
    }
    return OUTCOME_DONE;
}

/* Sum of the squares of a[j] - b[j] over the stages */
static double distance(const double *a, const double *b)
{
#if CCGEN_PRECISION /* no vectors of these numbers everywhere */
    double even = 0.0, odd = 0.0;
    for (int j = 0; j < STAGES; j += 2) {
        even += (a[j] - b[j]) * (a[j] - b[j]);
        odd += (a[j + 1] - b[j + 1]) * (a[j + 1] - b[j + 1]);
    }
    return even + odd;
#else
    typedef double pair __attribute__((vector_size(16), aligned(8), may_alias));
    const pair *x = (const pair *)a, *y = (const pair *)b;
    const pair d0 = x[0] - y[0], d1 = x[1] - y[1], d2 = x[2] - y[2], d3 = x[3] - y[3];
    const pair squares = (d0 * d0 + d1 * d1) + (d2 * d2 + d3 * d3);
    return squares[0] + squares[1];
#endif
}

/* Weighted root mean square of the change that the last sweep made */
static double change(const struct gauss *g)
{
    double sum = 0.0;
    for (int i = 0; i < g->n; i++)
        sum += distance(g->g + i * STAGES, g->f + i * STAGES) * (g->weight[i] * g->weight[i]);
    return sqrt(sum / (STAGES * g->n));
}

/* What the last change means for the end of the step, less its part across the closure, where projection removes that: near a
 * singular configuration accelerations are known badly in that direction alone. */
static enum outcome change_along(struct gauss *g, struct system *s, double h, const double *y, double *now)
{
    const int n = g->n;
    double *q = g->one, *by_q = q + n, *by_u = by_q + n, sum = 0.0;
    for (int i = 0; i < n; i++) {
        const double *f = g->f + i * STAGES, *old = g->g + i * STAGES;
        q[i] = y[i] + g->slope[i] + h * h * weighed(WEIGHT2, f);
        by_q[i] = h * h * (weighed(WEIGHT2, f) - weighed(WEIGHT2, old));
        by_u[i] = h * (weighed(WEIGHT, f) - weighed(WEIGHT, old));
    }
    enum outcome outcome = s->projects_steps ? project_velocity(s, q, by_q) : OUTCOME_DONE;
    if (!outcome && s->projects_steps)
        outcome = project_velocity(s, q, by_u);
    for (int i = 0; i < n; i++) {
        const double miss = g->weight[i] * (fabs(by_u[i] / h) + fabs(by_q[i]) / (h * h));
        sum += miss * miss;
    }
    *now = sqrt(sum / n);
    return outcome;
}

/* Sweep until what is left is small against the tolerance, or, where that is none, until rounding is met. `converged` is 0 if
 * the sweeps contract too slowly. */
static enum outcome converge(struct gauss *g, struct system *s, double t, double h, struct tolerance tolerance,
                             const double *y, int *converged)
{
    const int strict = tolerance.rtol == 0.0, most = strict ? SWEEPS_TO_ROUNDING : SWEEPS;
    double before = INFINITY;
    int standing = 0; /* sweeps in a row that hardly contract */
    *converged = 1;
    g->contraction = g->along = 0.0;
    for (int k = 1;; k++) {
        enum outcome outcome = sweep(g, s, t, h, y);
        if (outcome)
            return outcome;
        double now = change(g);
        double *swap = g->f;
        g->f = g->g;
        g->g = swap;
        if (!isfinite(now))
            return OUTCOME_NOT_FINITE;
        const double rate = now / before, bound = fmax(rate, DOUBT);
        before = now;
        if (k > 1 && now > 1.0)
            g->contraction = rate;
        if (now <= fmax(REST, g->grain) || (k > 1 && rate < STAGNANT && now * bound <= REST * (1.0 - bound)))
            return OUTCOME_DONE;
        standing = k > 1 && rate > STAGNANT ? standing + 1 : 0;
        const int hopeless = rate > SLOWEST || (rate > 0.25 && now * pow(rate, most - k) > 1.0);
        const int slow = k > 2 && (standing > 1 || (!strict && hopeless));
        if (!slow && k < most)
            continue;
        if ((outcome = change_along(g, s, h, y, &now)))
            return outcome;
        const double may = standing > 1 || s->branch ? fmax(STANDING, NEAR * g->grain) : REST;
        *converged = now <= may;
        g->along = strict ? 0.0 : may;
        if (k == most || !strict || *converged)
            return OUTCOME_DONE;
    }
}

enum outcome gauss_solve(struct gauss *g, struct system *s, double t, double h, struct tolerance tolerance,
                         const double *y, const double *dy, int *converged)
{
    *converged = 0;
    const enum outcome outcome = guess(g, s, t, h, y, dy);
    if (outcome)
        return outcome;
    prepare_sweeps(g, s, h, tolerance, y);
    return converge(g, s, t, h, tolerance, y, converged);
}
