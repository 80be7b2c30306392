/* Radau IIA with three stages: implicit Runge-Kutta of order 5 that damps what is stiff, for stiff springs and dampers
 * (E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, 1996, sections IV.5 and IV.8).
 *
 * Unknowns are the accelerations of the stages, first guessed by carrying on those of the step before. Simplified Newton iterations find them, with the derivatives of
 * the accelerations with respect to coordinates and velocities at a state before: of a model that was generated with its derivatives from
 * these, else by differences, as many at a time as there are lanes. The equations fall apart into one real and one complex system of
 * the size of the mechanism. Both, factorised, are kept from step to step, as long as iterations contract by them and steps are about as long; where they no longer do,
 * they are made anew at the start of the step.
 *
 * What a step misses is told by two estimates, of which the smaller counts. The embedded formula of order 3 is known at once, damps what is stiff, and is far larger than
 * what a smooth motion misses. The other is that itself: the error of the step is at most about h^6 / 7200 times a derivative of the accelerations, the fifth (of velocities; of
 * coordinates the fourth), known from a divided difference over the stages of this step and of the one before.
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
/* contraction up to which what was factorised is kept: one more iteration costs an evaluation of the stages, new differences some of them, exact derivatives less than one */
static const double KEPT = 0.05, KEPT_EXACT = 0.005;
static const double ALIKE =
    0.2; /* and the part by which steps may be of other lengths: what is stiff is damped as it would be by those */
static const double FAR =
    2.5; /* times the length of the step before that its accelerations are carried on by at most */
static const double LONGER =
    5.0; /* times this step: a step before that was longer knows nothing of what bends within this one. Of a jump the end misses a third of
          * what the divided difference then tells, at ten times nearly all, at a hundred 68 times as much */
static const double ENDS_ALIKE = 1e-9; /* part of a step by which the next one may begin elsewhere */
static const double CAUTION =
    200.0; /* times the error that the divided difference tells: its stages are of two steps, and have errors of their own */
static const double JUMP =
    2.7; /* times what the embedded formula says: where accelerations jump between two stages the end misses up to 2.66 of that */
static const double UNIT = 4.0 * DBL_EPSILON;
enum {
    ITERATIONS = 10,
    ITERATIONS_TO_ROUNDING = 40,
    ORDER = 5,
    ORDER_OF_ESTIMATE = 3,
    ESTIMATES = 2,
    POINTS = 2 * STAGES
};

typedef double complex number;

struct radau {
    double t, h;                     /* of the last attempt */
    double before;                   /* length of the step that `earlier` is of */
    double kept_t, kept_h;           /* where, and for which length of a step, the systems are of */
    double contraction;              /* of the last iterations */
    int failed;                      /* the iterations of the last step did not converge */
    int done;                        /* the last attempt has stages */
    int known;                       /* there is a step before */
    int told;                        /* the second estimate tells what the last attempt missed */
    int kept, lost;                  /* there are systems; they have to be made again, from kept_t, kept_y, kept_dy */
    int exact;                       /* they are of derivatives, not of differences */
    int n, rows, lanes, *pivots;     /* [2 n]: of the real and of the complex system */
    double *f;                       /* [rows][STAGES] accelerations, and power */
    double *at_start;                /* [rows] the same at the start */
    double *earlier, *earlier_start; /* the same of the step before */
    double *kept_y, *kept_dy;        /* [size] */
    double *miss;                    /* [n][STAGES] */
    double *q, *u, *out, *time;      /* [n][lanes], [lanes] */
    double *by_q, *by_u;             /* [n][n] derivatives of the accelerations */
    double *estimate;                /* [ESTIMATES][size] */
    double *start, *ends;    /* [size], [size][STAGES]: state at the start and at the stages, for interpolation */
    double *one;             /* [2 n] */
    number *real, *complex_; /* [n][n] factors of the two systems */
    number *x;               /* [n] */
    double *side;            /* of system_acceleration_lanes */
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
                 {&r->at_start, size - n},
                 {&r->earlier, (size - n) * STAGES},
                 {&r->earlier_start, size - n},
                 {&r->kept_y, size},
                 {&r->kept_dy, size},
                 {&r->miss, n * STAGES},
                 {&r->q, n * lanes},
                 {&r->u, n * lanes},
                 {&r->out, n * lanes},
                 {&r->time, lanes},
                 {&r->by_q, n * n},
                 {&r->by_u, n * n},
                 {&r->estimate, ESTIMATES * size},
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

static void radau_restart(double *scratch, int size)
{
    struct radau *r = (struct radau *)scratch;
    (void)size;
    r->done = r->known = r->kept = r->lost = 0;
    r->contraction = 0.0;
}

/* The last steps, and where the systems are of */
static size_t radau_memory(const struct system *s, double *scratch, int put, double *numbers)
{
    const size_t size = s->size, rows = size - s->n;
    enum { T, H, BEFORE, KEPT_T, KEPT_H, CONTRACTION, DONE, KNOWN, HAS, EXACT, SCALARS };
    if (!numbers)
        return SCALARS + 2 * rows * (STAGES + 1) + 2 * size;
    struct radau *r = radau_of(s, scratch);
    double scalars[SCALARS] = {r->t,           r->h,    r->before, r->kept_t, r->kept_h,
                               r->contraction, r->done, r->known,  r->kept,   r->exact};
    double *at = numbers;
    const struct {
        double *array;
        size_t count;
    } parts[] = {{scalars, SCALARS},       {r->f, rows * STAGES}, {r->at_start, rows}, {r->earlier, rows * STAGES},
                 {r->earlier_start, rows}, {r->kept_y, size},     {r->kept_dy, size}};
    for (size_t i = 0; i < sizeof parts / sizeof *parts; at += parts[i++].count)
        memcpy(put ? parts[i].array : at, put ? at : parts[i].array, parts[i].count * sizeof *at);
    if (!put)
        return (size_t)(at - numbers);
    r->t = scalars[T];
    r->h = scalars[H];
    r->before = scalars[BEFORE];
    r->kept_t = scalars[KEPT_T];
    r->kept_h = scalars[KEPT_H];
    r->contraction = scalars[CONTRACTION];
    r->done = scalars[DONE] != 0.0;
    r->known = scalars[KNOWN] != 0.0;
    r->kept = r->lost = scalars[HAS] != 0.0;
    r->exact = scalars[EXACT] != 0.0;
    return (size_t)(at - numbers);
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
        const enum outcome outcome = system_acceleration_lanes(s, 2 * n - first, r->time, r->q, r->u, r->out, r->side);
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
    const enum outcome outcome = acceleration_jacobian(s, t, y, y + r->n, r->by_q, r->by_u, &r->exact);
    return outcome || r->exact ? outcome : take_differences(r, s, t, y, dy);
}

static double size_of(number x)
{
    return fabs(creal(x)) + fabs(cimag(x));
}

/* a = factors of 1 - z du_dot/du - z^2 du_dot/dq, with rows exchanged, and one over each pivot; 0, or 1 if there are none or the run is to end */
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
            if (size_of(a[i * n + k]) > size_of(a[best * n + k]))
                best = i;
        pivots[k] = best;
        if (!(size_of(a[best * n + k]) > 0.0))
            return 1;
        for (int j = 0; j < n && best != k; j++) {
            const number swap = a[k * n + j];
            a[k * n + j] = a[best * n + j];
            a[best * n + j] = swap;
        }
        a[k * n + k] = 1.0 / a[k * n + k];
        for (int i = k + 1; i < n; i++) {
            const number factor = a[i * n + k] *= a[k * n + k];
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
        x[k] *= a[k * n + k];
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
        const enum outcome outcome = system_acceleration_lanes(s, STAGES - first, r->time, r->q, r->u, r->out, r->side);
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

/* Size of r->miss, changes of accelerations, in tolerances, or in what rounding makes of the motion where that is more: of the speed, and of the largest acceleration
 * of all stages, as from rest there is none at the start. `grain` is the size of that rounding. */
static double size_of_miss(const struct radau *r, const struct system *s, double h, struct tolerance tolerance,
                           const double *y, double *grain)
{
    const int n = r->n;
    double moves = 0.0, sum = 0.0;
    for (int i = 0; i < n; i++) {
        moves = fmax(moves, fabs(y[n + i]) / s->unit[i]);
        for (int j = 0; j < STAGES; j++)
            moves = fmax(moves, fabs(h * r->f[i * STAGES + j]) / s->unit[i]);
    }
    *grain = 0.0;
    for (int i = 0; i < n; i++) {
        const double rounding = UNIT * moves * s->unit[i];
        const double known = fmax(allowed_error(tolerance, n + i, fabs(y[n + i])), rounding);
        *grain = fmax(*grain, known > 0.0 ? rounding / known : 0.0);
        for (int j = 0; j < STAGES; j++) {
            const double part = h * r->miss[i * STAGES + j] / fmax(known, DBL_MIN);
            sum += part * part;
        }
    }
    return sqrt(sum / (STAGES * n));
}

/* Iterate until what is left is small against the tolerance, or, where that is none, until rounding is met.
 *
 * A small correction tells nothing by itself: systems that are far stiffer than the motion is make small ones of all that the stages miss. So what they miss is small
 * too, or corrections have become smaller, or are rounding. */
static enum outcome converge(struct radau *r, struct system *s, double t, double h, struct tolerance tolerance,
                             const double *y, int *converged)
{
    const int strict = tolerance.rtol == 0.0;
    double before = INFINITY, contraction = 0.0, grain;
    *converged = 0;
    for (int k = 1; k <= (strict ? ITERATIONS_TO_ROUNDING : ITERATIONS); k++) {
        const enum outcome outcome = miss(r, s, t, h, y);
        if (outcome)
            return outcome;
        const double missed = size_of_miss(r, s, h, tolerance, y, &grain);
        correct(r);
        const double now = size_of_miss(r, s, h, tolerance, y, &grain), rate = now / before, bound = fmax(rate, DOUBT);
        before = now;
        contraction = fmax(contraction, rate);
        if (!isfinite(now))
            return OUTCOME_NOT_FINITE;
        const int small = now <= REST && (missed <= REST || now <= grain || (k > 1 && rate <= SLOWEST));
        if (small || (k > 1 && bound <= SLOWEST && now * bound <= REST * (1.0 - bound)) ||
            (strict && k > 3 && rate > 0.5 && now <= 1e5)) { /* rounding, which stiffness has made large */
            if (k > 1)                                       /* one alone tells no rate */
                r->contraction = contraction;
            *converged = 1;
            return OUTCOME_DONE;
        }
        if (!strict && k > 2 && rate > SLOWEST)
            break;
    }
    r->contraction = contraction;
    return OUTCOME_DONE;
}

/* What is left of errors by_q[n], by_u[n] where what is stiff is damped as the real system does */
static void smooth(struct radau *r, double *by_q, double *by_u)
{
    const int n = r->n;
    const double z = REAL * r->kept_h;
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
}

/* What the embedded formula of order 3 says */
static void estimate(struct radau *r, double h, const double *y, const double *dy)
{
    const int n = r->n, size = n + r->rows;
    for (int i = 0; i < size; i++) { /* also of the work: power does not depend on it */
        r->estimate[i] = REAL * h * dy[i];
        for (int j = 0; j < STAGES; j++)
            r->estimate[i] += ESTIMATE[j] * (r->ends[i * STAGES + j] - y[i]);
        r->estimate[i] *= JUMP;
    }
    smooth(r, r->estimate, r->estimate + n);
}

/* weight[POINTS] of the accelerations at points `first` and on of those of two steps in the divided difference of them all, of times in lengths of the second step: the stages
 * of the first but its end, the start of the second, its stages */
static void divide(double ratio, int first, double *weight)
{
    const double at[POINTS] = {ratio * (NODE[0] - 1.0), ratio * (NODE[1] - 1.0), 0.0, NODE[0], NODE[1], NODE[2]};
    for (int j = first; j < POINTS; j++) {
        weight[j] = 1.0;
        for (int k = first; k < POINTS; k++)
            if (k != j)
                weight[j] /= at[j] - at[k];
    }
}

/* What divided differences of order 5 and 4 over this step and the one before say: at most about h^6 / 7200 times derivatives, which they are 1/120 and 1/24 of */
static void estimate_by_differences(struct radau *r, double h)
{
    const int n = r->n, size = n + r->rows;
    double fifth[POINTS], fourth[POINTS] = {0.0}, *found = r->estimate + size;
    divide(r->before / h, 0, fifth);
    divide(r->before / h, 1, fourth);
    for (int i = 0; i < r->rows; i++) {
        const double *e = r->earlier + i * STAGES, *f = r->f + i * STAGES;
        const double at[POINTS] = {e[0], e[1], r->at_start[i], f[0], f[1], f[2]};
        double of_u = 0.0, of_q = 0.0;
        for (int j = 0; j < POINTS; j++) {
            of_u += fifth[j] * at[j];
            of_q += fourth[j] * at[j];
        }
        found[n + i] = CAUTION * h / 60.0 * of_u;
        if (i < n)
            found[i] = CAUTION * h * h / 300.0 * of_q;
    }
    smooth(r, found, found + n);
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

/* What the last attempt leaves to the next, if it was accepted */
static void go_on(struct radau *r, double t)
{
    if (r->done && t != r->t) {
        double *swap = r->earlier;
        r->earlier = r->f;
        r->f = swap;
        swap = r->earlier_start;
        r->earlier_start = r->at_start;
        r->at_start = swap;
        r->known = fabs(t - (r->t + r->h)) <= ENDS_ALIKE * fabs(r->h);
        r->before = r->h;
    }
    r->done = 0;
}

/* First values of the stages: the cubic through the start and the stages of the step before, carried on if that `carries`, or else the start */
static void guess(struct radau *r, double h, int carries, const double *dy)
{
    const int n = r->n;
    const double at[STAGES + 1] = {0.0, NODE[0], NODE[1], NODE[2]};
    double weight[STAGES][STAGES + 1];
    for (int j = 0; j < STAGES; j++)
        for (int k = 0; k <= STAGES; k++) {
            const double x = 1.0 + NODE[j] * h / r->before;
            weight[j][k] = 1.0;
            for (int l = 0; l <= STAGES; l++)
                weight[j][k] *= l == k ? 1.0 : (x - at[l]) / (at[k] - at[l]);
        }
    for (int i = 0; i < n; i++) {
        const double *e = r->earlier + i * STAGES, left = dy[n + i] - e[STAGES - 1];
        for (int j = 0; j < STAGES; j++)
            r->f[i * STAGES + j] = !carries ? dy[n + i]
                                            : weight[j][0] * r->earlier_start[i] + weight[j][1] * e[0] +
                                                  weight[j][2] * e[1] + weight[j][3] * e[2] + left;
    }
}

/* The systems at the state that is kept */
static enum outcome make_systems(struct radau *r, struct system *s)
{
    const double h = r->kept_h;
    const enum outcome outcome = differentiate(r, s, r->kept_t, r->kept_y, r->kept_dy);
    if (outcome)
        return outcome;
    if (factorise(r, s, REAL * h, r->real, r->pivots) ||
        factorise(r, s, (COMPLEX_REAL + I * COMPLEX_IMAGINARY) * h, r->complex_, r->pivots + r->n))
        return interrupted(s->interruption, 0) ? OUTCOME_INTERRUPTED : OUTCOME_NOT_FINITE;
    r->kept = 1;
    r->lost = 0;
    return OUTCOME_DONE;
}

/* The systems anew, of a step of length h from (t, y) */
static enum outcome renew(struct radau *r, struct system *s, double t, double h, const double *y, const double *dy)
{
    r->kept = 0;
    r->kept_t = t;
    r->kept_h = h;
    memcpy(r->kept_y, y, s->size * sizeof *y);
    memcpy(r->kept_dy, dy, s->size * sizeof *dy);
    return make_systems(r, s);
}

/* The stages, by systems that are kept where these do, and from where the step before leads where that does; else by systems of this step, from its start */
static enum outcome find_stages(struct radau *r, struct system *s, double t, double h, struct tolerance tolerance,
                                const double *y, const double *dy, int *converged)
{
    const int keeps = r->kept && r->contraction <= (r->exact ? KEPT_EXACT : KEPT) && tolerance.rtol > 0.0 &&
                      fabs(h - r->kept_h) <= ALIKE * fabs(r->kept_h);
    const int carries = r->known && fabs(h) <= FAR * fabs(r->before);
    enum outcome outcome = !keeps ? renew(r, s, t, h, y, dy) : r->lost ? make_systems(r, s) : OUTCOME_DONE;
    if (outcome)
        return outcome;
    guess(r, h, carries, dy);
    outcome = converge(r, s, t, h, tolerance, y, converged);
    if ((!keeps && !carries) || outcome == OUTCOME_INTERRUPTED || (!outcome && *converged))
        return outcome;
    outcome = keeps ? renew(r, s, t, h, y, dy) : OUTCOME_DONE;
    guess(r, h, 0, dy);
    return outcome ? outcome : converge(r, s, t, h, tolerance, y, converged);
}

static enum outcome radau_step(struct system *s, double *scratch, double t, double h, struct tolerance tolerance,
                               const double *y, const double *dy, double *y1)
{
    struct radau *r = radau_of(s, scratch);
    int converged = 0;
    go_on(r, t);
    r->t = t;
    r->h = h;
    r->failed = 0;
    memcpy(r->at_start, dy + r->n, r->rows * sizeof *dy);
    enum outcome outcome = find_stages(r, s, t, h, tolerance, y, dy, &converged);
    if (!outcome)
        outcome = finish(r, s, t, h, y, y1);
    if (outcome)
        return outcome;
    estimate(r, h, y, dy);
    r->told = r->known && fabs(r->before) <= LONGER * fabs(h);
    if (r->told)
        estimate_by_differences(r, h);
    memcpy(r->start, y, s->size * sizeof *y);
    r->done = converged;
    r->failed = !converged;
    return r->failed && tolerance.rtol == 0.0 ? OUTCOME_NO_CONVERGENCE : OUTCOME_DONE;
}

static double *radau_estimates(double *scratch, int size, int *count)
{
    struct radau *r = (struct radau *)scratch;
    (void)size;
    *count = r->told ? ESTIMATES : 1;
    return r->estimate;
}

/* As the error of a method of this order would be, of estimates of order `of` */
static double measured(const double *found, int of, int size, struct tolerance tolerance, const double *y,
                       const double *y1)
{
    double sum = 0.0;
    for (int i = 0; i < size; i++) {
        const double scale = allowed_error(tolerance, i, fmax(fabs(y[i]), fabs(y1[i])));
        sum += (found[i] / scale) * (found[i] / scale);
    }
    return pow(sum / size, 0.5 * ORDER / (of + 1));
}

static double radau_measure(const double *scratch, int size, struct tolerance tolerance, const double *y,
                            const double *y1)
{
    const struct radau *r = (const struct radau *)scratch;
    if (r->failed)
        return pow(0.9 * 3.0, ORDER); /* a third of the step */
    const double error = measured(r->estimate, ORDER_OF_ESTIMATE, size, tolerance, y, y1);
    return r->told ? fmin(error, measured(r->estimate + size, ORDER, size, tolerance, y, y1)) : error;
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
    .restart = radau_restart,
    .memory = radau_memory,
    .step = radau_step,
    .estimates = radau_estimates,
    .measure = radau_measure,
    .prepare = radau_prepare,
    .interpolate = radau_interpolate,
};
