/* Radau IIA with three stages: implicit Runge-Kutta of order 5 that damps what is stiff, for stiff springs and dampers
 * (E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, 1996, sections IV.5 and IV.8).
 *
 * Unknowns are the accelerations of the stages. Simplified Newton iterations find them, with the derivatives of the accelerations
 * with respect to coordinates and velocities at the start of the step: of a model that was generated with its derivatives from
 * these, else by differences, as many at a time as there are lanes. The equations fall apart into one real and one complex system of
 * the size of the mechanism.
 */
#include "methods/method.h"

#include <complex.h>
#include <float.h>
#include <math.h>
#include <string.h>

#include "methods/radau_tableau.h"
#include "motion/jacobian.h"
#include "motion/lanes.h"
#include "motion/power.h"

static const double REST = 0.003;  /* part of the tolerance that iterations leave */
static const double SLOWEST = 0.7; /* contraction beyond which a step is given up */
static const double DOUBT = 0.05;  /* iterations are not believed to contract faster */
/* of a number by which it is changed to see what follows, and at least of 1 */
static const double DIFFERENCE = CCGEN_ROOT_EPSILON;
static const double UNIT = 4.0 * DBL_EPSILON;
enum { ITERATIONS = 10, ITERATIONS_TO_ROUNDING = 40, ORDER = 5, ORDER_OF_ESTIMATE = 3 };

typedef double complex number;

struct radau {
    double h;
    int failed;                  /* the iterations of the last step did not converge */
    int n, rows, lanes, *pivots; /* [2 n]: of the real and of the complex system */
    double *f;                   /* [rows][STAGES] accelerations, and power */
    double *miss;                /* [n][STAGES] */
    double *q, *u, *out, *time;  /* [n][lanes], [lanes] */
    double *by_q, *by_u;         /* [n][n] derivatives of the accelerations */
    double *estimate;            /* [size] */
    double *start, *ends;        /* [size], [size][STAGES]: state at the start and at the stages, for interpolation */
    double *one;                 /* [2 n] */
    number *real, *complex_;     /* [n][n] factors of the two systems */
    number *x;                   /* [n] */
    double *side;                /* of system_acceleration_lanes */
};

static const size_t HEAD = (sizeof(struct radau) + sizeof(double) - 1) / sizeof(double);

/* Lays the arrays out from `at` on, unless it is NULL; returns how many numbers they take. */
static size_t lay_out(struct radau *r, const struct system *s, double *at)
{
    const size_t n = s->n, size = s->size, lanes = s->model->lanes;
    double *real = NULL, *complex_ = NULL, *x = NULL, *pivots = NULL;
    const struct {
        double **array;
        size_t count;
    } parts[] = {{&real, 2 * n * n},
                 {&complex_, 2 * n * n},
                 {&x, 2 * n},
                 {&pivots, 2 * n},
                 {&r->f, (size - n) * STAGES},
                 {&r->miss, n * STAGES},
                 {&r->q, n * lanes},
                 {&r->u, n * lanes},
                 {&r->out, n * lanes},
                 {&r->time, lanes},
                 {&r->by_q, n * n},
                 {&r->by_u, n * n},
                 {&r->estimate, size},
                 {&r->start, size},
                 {&r->ends, size * STAGES},
                 {&r->one, 2 * n},
                 {&r->side, lanes_scratch(s)}};
    size_t total = 0;
    for (size_t i = 0; i < sizeof parts / sizeof *parts; i++) {
        if (at)
            *parts[i].array = at + total;
        total += parts[i].count;
    }
    if (at) {
        r->real = (number *)real;
        r->complex_ = (number *)complex_;
        r->x = (number *)x;
        r->pivots = (int *)pivots;
    }
    return total;
}

static size_t radau_scratch(const struct system *s)
{
    struct radau r;
    return HEAD + lay_out(&r, s, NULL);
}

static struct radau *radau_of(const struct system *s, double *scratch)
{
    struct radau *r = (struct radau *)scratch;
    if (!r->f) {
        lay_out(r, s, scratch + HEAD);
        r->n = s->n;
        r->rows = s->size - s->n;
        r->lanes = s->model->lanes;
    }
    return r;
}

/* by_q, by_u by differences from the accelerations dy at (t, y) */
static enum outcome take_differences(struct radau *r, struct system *s, double t, const double *y, const double *dy)
{
    const int n = r->n, lanes = r->lanes;
    for (int first = 0; first < 2 * n; first += lanes) {
        for (int l = 0; l < lanes; l++) {
            r->time[l] = t;
            for (int i = 0; i < n; i++) {
                r->q[i * lanes + l] = y[i];
                r->u[i * lanes + l] = y[n + i];
            }
            const int c = first + l;
            if (c < 2 * n)
                (c < n ? r->q : r->u)[c % n * lanes + l] += DIFFERENCE * (s->unit[c] + fabs(y[c]));
        }
        const enum outcome outcome = system_acceleration_lanes(s, r->time, r->q, r->u, r->out, r->side);
        if (outcome)
            return outcome;
        for (int l = 0; l < lanes && first + l < 2 * n; l++) {
            const int c = first + l;
            const double by = (c < n ? r->q : r->u)[c % n * lanes + l] - y[c];
            double *column = (c < n ? r->by_q : r->by_u) + c % n;
            for (int i = 0; i < n; i++)
                column[i * n] = (r->out[i * lanes + l] - dy[n + i]) / by;
        }
    }
    return OUTCOME_DONE;
}

/* by_q, by_u: how the accelerations dy[n] at (t, y) change with each coordinate and velocity */
static enum outcome differentiate(struct radau *r, struct system *s, double t, const double *y, const double *dy)
{
    int known;
    const enum outcome outcome = acceleration_jacobian(s, t, y, y + r->n, r->by_q, r->by_u, &known);
    return outcome || known ? outcome : take_differences(r, s, t, y, dy);
}

/* a = factors of 1 - z du_dot/du - z^2 du_dot/dq, with rows exchanged; 0, or 1 if there are none or the run is to end */
static int factorise(const struct radau *r, struct system *s, number z, number *a, int *pivots)
{
    const int n = r->n;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            a[i * n + j] = (i == j) - z * (r->by_u[i * n + j] + z * r->by_q[i * n + j]);
    for (int k = 0; k < n; k++) {
        if (interrupted(s->interruption, (long)(n - k) * (n - k)))
            return 1;
        int best = k;
        for (int i = k + 1; i < n; i++)
            if (cabs(a[i * n + k]) > cabs(a[best * n + k]))
                best = i;
        pivots[k] = best;
        if (!(cabs(a[best * n + k]) > 0.0))
            return 1;
        for (int j = 0; j < n && best != k; j++) {
            const number swap = a[k * n + j];
            a[k * n + j] = a[best * n + j];
            a[best * n + j] = swap;
        }
        for (int i = k + 1; i < n; i++) {
            const number factor = a[i * n + k] /= a[k * n + k];
            for (int j = k + 1; j < n && factor != 0.0; j++)
                a[i * n + j] -= factor * a[k * n + j];
        }
    }
    return 0;
}

static void solve(int n, const number *a, const int *pivots, number *x)
{
    for (int k = 0; k < n; k++) {
        const number swap = x[pivots[k]];
        x[pivots[k]] = x[k];
        x[k] = swap;
    }
    for (int k = 0; k < n; k++)
        for (int i = k + 1; i < n; i++)
            x[i] -= a[i * n + k] * x[k];
    for (int k = n - 1; k >= 0; k--) {
        x[k] /= a[k * n + k];
        for (int i = 0; i < k; i++)
            x[i] -= a[i * n + k] * x[k];
    }
}

/* state of stage j for accelerations f: coordinates q[stride * i], velocities u[stride * i] */
static void stage(const struct radau *r, int j, double h, const double *y, double *q, double *u, int stride)
{
    for (int i = 0; i < r->n; i++) {
        const double *f = r->f + i * STAGES;
        u[i * stride] = y[r->n + i] + h * (ONCE[j][0] * f[0] + ONCE[j][1] * f[1] + ONCE[j][2] * f[2]);
        q[i * stride] =
            y[i] + h * (NODE[j] * y[r->n + i] + h * (TWICE[j][0] * f[0] + TWICE[j][1] * f[1] + TWICE[j][2] * f[2]));
    }
}

/* miss = accelerations along the motion that f gives, less f */
static enum outcome miss(struct radau *r, struct system *s, double t, double h, const double *y)
{
    const int n = r->n, lanes = r->lanes;
    for (int first = 0; first < STAGES; first += lanes) {
        for (int l = 0; l < lanes; l++) {
            const int j = first + l < STAGES ? first + l : STAGES - 1;
            r->time[l] = t + NODE[j] * h;
            stage(r, j, h, y, r->q + l, r->u + l, lanes);
        }
        const enum outcome outcome = system_acceleration_lanes(s, r->time, r->q, r->u, r->out, r->side);
        if (outcome)
            return outcome;
        for (int l = 0; l < lanes && first + l < STAGES; l++)
            for (int i = 0; i < n; i++)
                r->miss[i * STAGES + first + l] = r->out[i * lanes + l] - r->f[i * STAGES + first + l];
    }
    return OUTCOME_DONE;
}

/* One Newton correction of f; it is left in `miss`. */
static void correct(struct radau *r)
{
    const int n = r->n;
    for (int mode = 0; mode < 2; mode++) {
        for (int i = 0; i < n; i++) {
            const double *m = r->miss + i * STAGES;
            double part[STAGES];
            for (int k = 0; k < STAGES; k++)
                part[k] = INVERSE[k][0] * m[0] + INVERSE[k][1] * m[1] + INVERSE[k][2] * m[2];
            r->x[i] = mode ? part[1] - I * part[2] : part[0];
        }
        solve(n, mode ? r->complex_ : r->real, r->pivots + mode * n, r->x);
        for (int i = 0; i < n; i++) /* the real mode waits in `out`, the complex one is in x */
            if (!mode)
                r->one[i] = creal(r->x[i]);
    }
    for (int i = 0; i < n; i++) {
        const double part[STAGES] = {r->one[i], creal(r->x[i]), -cimag(r->x[i])};
        for (int j = 0; j < STAGES; j++) {
            const double by = MODES[j][0] * part[0] + MODES[j][1] * part[1] + MODES[j][2] * part[2];
            r->f[i * STAGES + j] += by;
            r->miss[i * STAGES + j] = by;
        }
    }
}

/* Size of the last correction in tolerances, or in what rounding makes of the motion where that is more: of the speed, and of the largest acceleration
 * of all stages, as from rest there is none at the start. */
static double size_of_correction(const struct radau *r, const struct system *s, double h, struct tolerance tolerance,
                                 const double *y)
{
    const int n = r->n;
    double moves = 0.0, sum = 0.0;
    for (int i = 0; i < n; i++) {
        moves = fmax(moves, fabs(y[n + i]) / s->unit[i]);
        for (int j = 0; j < STAGES; j++)
            moves = fmax(moves, fabs(h * r->f[i * STAGES + j]) / s->unit[i]);
    }
    for (int i = 0; i < n; i++) {
        const double known = fmax(allowed_error(tolerance, n + i, fabs(y[n + i])), UNIT * moves * s->unit[i]);
        for (int j = 0; j < STAGES; j++) {
            const double part = h * r->miss[i * STAGES + j] / fmax(known, DBL_MIN);
            sum += part * part;
        }
    }
    return sqrt(sum / (STAGES * n));
}

/* Iterate until what is left is small against the tolerance, or, where that is none, until rounding is met. */
static enum outcome converge(struct radau *r, struct system *s, double t, double h, struct tolerance tolerance,
                             const double *y, int *converged)
{
    const int strict = tolerance.rtol == 0.0;
    double before = INFINITY;
    *converged = 0;
    for (int k = 1; k <= (strict ? ITERATIONS_TO_ROUNDING : ITERATIONS); k++) {
        const enum outcome outcome = miss(r, s, t, h, y);
        if (outcome)
            return outcome;
        correct(r);
        const double now = size_of_correction(r, s, h, tolerance, y), rate = now / before, bound = fmax(rate, DOUBT);
        before = now;
        if (!isfinite(now))
            return OUTCOME_NOT_FINITE;
        if (now <= REST || (k > 1 && bound < 1.0 && now * bound <= REST * (1.0 - bound)) ||
            (strict && k > 3 && rate > 0.5 && now <= 1e5)) { /* rounding, which stiffness has made large */
            *converged = 1;
            return OUTCOME_DONE;
        }
        if (!strict && k > 2 && rate > SLOWEST)
            break;
    }
    return OUTCOME_DONE;
}

/* What the embedded formula of order 3 says, smoothed by the real system. */
static void estimate(struct radau *r, double h, const double *y, const double *dy)
{
    const int n = r->n;
    const double z = REAL * h;
    double *by_q = r->estimate, *by_u = by_q + n;
    for (int i = 0; i < n; i++) {
        by_q[i] = z * dy[i];
        by_u[i] = z * dy[n + i];
        for (int j = 0; j < STAGES; j++) {
            by_q[i] += ESTIMATE[j] * (r->ends[i * STAGES + j] - y[i]);
            by_u[i] += ESTIMATE[j] * (r->ends[(n + i) * STAGES + j] - y[n + i]);
        }
    }
    for (int i = 0; i < n; i++) {
        double sum = by_u[i];
        for (int j = 0; j < n; j++)
            sum += z * r->by_q[i * n + j] * by_q[j];
        r->x[i] = sum;
    }
    solve(n, r->real, r->pivots, r->x);
    for (int i = 0; i < n; i++) {
        by_u[i] = creal(r->x[i]);
        by_q[i] += z * by_u[i];
    }
    if (r->rows > n) { /* the work: power does not depend on it */
        const double *work = r->ends + 2 * n * STAGES;
        r->estimate[2 * n] = z * dy[2 * n];
        for (int j = 0; j < STAGES; j++)
            r->estimate[2 * n] += ESTIMATE[j] * (work[j] - y[2 * n]);
    }
}

/* States at the stages, the last of which is the end of the step, and the work. */
static enum outcome finish(struct radau *r, struct system *s, double t, double h, const double *y, double *y1)
{
    const int n = r->n;
    double *power = r->f + n * STAGES, *work = r->ends + 2 * n * STAGES;
    for (int j = 0; j < STAGES; j++)
        stage(r, j, h, y, r->ends + j, r->ends + n * STAGES + j, STAGES);
    for (int i = 0; i < 2 * n; i++)
        y1[i] = r->ends[i * STAGES + STAGES - 1];
    for (int j = 0; j < STAGES && s->size > 2 * n; j++) {
        for (int i = 0; i < 2 * n; i++)
            r->one[i] = r->ends[i * STAGES + j];
        const enum outcome outcome = system_power(s, t + NODE[j] * h, r->one, r->one + n, power + j);
        if (outcome)
            return outcome;
    }
    for (int j = 0; j < STAGES && s->size > 2 * n; j++)
        work[j] = y[2 * n] + h * (ONCE[j][0] * power[0] + ONCE[j][1] * power[1] + ONCE[j][2] * power[2]);
    if (s->size > 2 * n)
        y1[2 * n] = work[STAGES - 1];
    return OUTCOME_DONE;
}

static enum outcome radau_step(struct system *s, double *scratch, double t, double h, struct tolerance tolerance,
                               const double *y, const double *dy, double *y1)
{
    struct radau *r = radau_of(s, scratch);
    const int n = r->n;
    int converged = 0;
    r->h = h;
    r->failed = 0;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < STAGES; j++)
            r->f[i * STAGES + j] = dy[n + i];
    enum outcome outcome = differentiate(r, s, t, y, dy);
    if (!outcome && (factorise(r, s, REAL * h, r->real, r->pivots) ||
                     factorise(r, s, (COMPLEX_REAL + I * COMPLEX_IMAGINARY) * h, r->complex_, r->pivots + n)))
        outcome = interrupted(s->interruption, 0) ? OUTCOME_INTERRUPTED : OUTCOME_NOT_FINITE;
    if (!outcome)
        outcome = converge(r, s, t, h, tolerance, y, &converged);
    if (!outcome)
        outcome = finish(r, s, t, h, y, y1);
    if (outcome)
        return outcome;
    estimate(r, h, y, dy);
    memcpy(r->start, y, s->size * sizeof *y);
    r->failed = !converged;
    return r->failed && tolerance.rtol == 0.0 ? OUTCOME_NO_CONVERGENCE : OUTCOME_DONE;
}

static double *radau_estimates(double *scratch, int size, int *count)
{
    (void)size;
    *count = 1;
    return ((struct radau *)scratch)->estimate;
}

static double radau_measure(const double *scratch, int size, struct tolerance tolerance, const double *y,
                            const double *y1)
{
    const struct radau *r = (const struct radau *)scratch;
    double sum = 0.0;
    if (r->failed)
        return pow(0.9 * 3.0, ORDER); /* a third of the step */
    for (int i = 0; i < size; i++) {
        const double scale = allowed_error(tolerance, i, fmax(fabs(y[i]), fabs(y1[i])));
        sum += (r->estimate[i] / scale) * (r->estimate[i] / scale);
    }
    return pow(sum / size, 0.5 * ORDER / (ORDER_OF_ESTIMATE + 1)); /* as the error of a method of this order would be */
}

static enum outcome radau_prepare(struct system *s, double *scratch, double t, double h, const double *y,
                                  const double *dy, const double *y1, const double *dy1)
{
    struct radau *r = (struct radau *)scratch;
    (void)t, (void)h, (void)dy, (void)dy1;
    memcpy(r->start, y, s->size * sizeof *y);
    for (int i = 0; i < s->size; i++)
        r->ends[i * STAGES + STAGES - 1] = y1[i];
    return OUTCOME_DONE;
}

/* The cubic through the start and the stages */
static void radau_interpolate(const double *scratch, int size, double theta, double *y)
{
    const struct radau *r = (const struct radau *)scratch;
    double weight[STAGES];
    for (int j = 0; j < STAGES; j++) {
        weight[j] = theta / NODE[j];
        for (int k = 0; k < STAGES; k++)
            if (k != j)
                weight[j] *= (theta - NODE[k]) / (NODE[j] - NODE[k]);
    }
    for (int i = 0; i < size; i++) {
        y[i] = r->start[i];
        for (int j = 0; j < STAGES; j++)
            y[i] += weight[j] * (r->ends[i * STAGES + j] - r->start[i]);
    }
}

const struct method radau = {
    .name = "radau",
    .order = ORDER,
    .damps = 1,
    .derivatives = 1,
    .scratch = radau_scratch,
    .step = radau_step,
    .estimates = radau_estimates,
    .measure = radau_measure,
    .prepare = radau_prepare,
    .interpolate = radau_interpolate,
};
