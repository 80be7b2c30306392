/* Where steps are looked through for events of the scene: in the eighths in which an indicator may come to zero.
 *
 * Places and velocities within a step are those of the dense output of its method where it is at hand, as by collocation; else they follow from those at its ends and from the
 * accelerations there, as a quintic. What that is wrong by is less than what the cubic without the accelerations differs from it. So a step is quiet between two of its samples if each
 * indicator stays farther from zero there than it could come at its rate, or by as much as it changes anywhere between two samples where that is not known, and by that error. Not one
 * bit of the motion changes.
 */
#include "steps/scene_events.h"

#include <float.h>
#include <limits.h>
#include <math.h>

static const double WRONG =
    2.0; /* times what cubic and quintic differ by at 3/8 and 5/8 of the step, where both their weights are near to their largest, it may be elsewhere */

/* What indicators are at one sample */
struct sample {
    double *value, *rate, *size;
};

static struct sample take_sample(struct arena *arena, int count)
{
    return (struct sample){TAKE(arena, double, count), TAKE(arena, double, count), TAKE(arena, double, count)};
}

/* The state at the part x of the step by the quintic, or by the cubic, without accelerations */
static void state_within(const struct phase *f, double x, int quintic, double *y)
{
    const int n = f->s->n;
    const double h = f->h, x2 = x * x, x3 = x2 * x;
    /* the cubic: weights of the places at both ends, and of the velocities times h; and the derivatives of these */
    const double p1 = x2 * (3.0 - 2.0 * x), v0 = x - 2.0 * x2 + x3, v1 = x3 - x2;
    const double dp1 = 6.0 * (x - x2), dv0 = 1.0 - 4.0 * x + 3.0 * x2, dv1 = 3.0 * x2 - 2.0 * x;
    /* what is added to it: of what it misses of the accelerations times h^2 at either end */
    const double left = 1.0 - x, b0 = 0.5 * x2 * left * left * left, b1 = 0.5 * x3 * left * left;
    const double db0 = x * left * left * left - 1.5 * x2 * left * left, db1 = 1.5 * x2 * left * left - x3 * left;
    for (int i = 0; i < n; i++) {
        const double way = f->y1[i] - f->y[i], u0 = h * f->y[n + i], u1 = h * f->y1[n + i];
        y[i] = f->y[i] + p1 * way + v0 * u0 + v1 * u1;
        double speed = dp1 * way + dv0 * u0 + dv1 * u1;
        if (quintic) {
            const double a0 = h * h * f->dy[n + i] - (6.0 * way - 4.0 * u0 - 2.0 * u1),
                         a1 = h * h * f->dy1[n + i] - (-6.0 * way + 2.0 * u0 + 4.0 * u1);
            y[i] += b0 * a0 + b1 * a1;
            speed += db0 * a0 + db1 * a1;
        }
        y[n + i] = speed / h;
    }
}

/* Whether one indicator may come to zero between two samples in which it changes by up to `most` of itself where its rate is not known, and is known to `wrong` */
static int may_vanish(const struct phase *f, int i, const struct sample *a, const struct sample *b, double most,
                      double wrong)
{
    const double reach =
        f->s->model->rated[i] ? fmax(fabs(a->rate[i]), fabs(b->rate[i])) * fabs(f->h) / EVENT_PARTS : most;
    const double zero = INDICATOR_ROUNDINGS * DBL_EPSILON * fmax(a->size[i], b->size[i]);
    const double nearest =
        (a->value[i] < 0.0) == (b->value[i] < 0.0) ? fmin(fabs(a->value[i]), fabs(b->value[i])) : 0.0;
    return isnan(a->value[i]) || isnan(b->value[i]) || !(nearest > reach + wrong + zero);
}

unsigned char where_events_may_be(struct phase *f)
{
    struct system *s = f->s;
    const struct ccgen_model *m = s->model;
    const int count = m->indicators;
    const struct mark mark = s->arena->top;
    const double scales[] = {s->length, s->time};
    struct sample at[EVENT_PARTS + 1], cubic = take_sample(s->arena, count);
    double *y = TAKE(s->arena, double, s->size), *wrong = TAKE_ZEROS(s->arena, double, count);
    unsigned char found = 0;
    for (int i = 0; i < count && m->change_by; i++)
        if (m->change_by[i] == 1) { /* of a force nothing is known */
            give_back(s->arena, mark);
            return UCHAR_MAX;
        }
    for (int k = 0; k <= EVENT_PARTS; k++)
        at[k] = take_sample(s->arena, count);
    const int dense = !f->by->derivatives;
    int unknown = s->arena->ran_out;
    if (!unknown && dense && !m->contacts)
        unknown = f->by->prepare(s, f->steps, f->t, f->h, f->y, f->dy, f->y1, f->dy1) != OUTCOME_DONE;
    if (unknown) {
        give_back(s->arena, mark);
        return UCHAR_MAX;
    }
    for (int k = 0; k <= EVENT_PARTS; k++) {
        const double x = (double)k / EVENT_PARTS;
        if (dense)
            f->by->interpolate(f->steps, s->size, x, y);
        else
            state_within(f, x, 1, y);
        m->indicate(s->k, y, y + s->n, f->t + x * f->h, scales, at[k].value, at[k].rate, at[k].size);
        if (2 * k != EVENT_PARTS - 2 && 2 * k != EVENT_PARTS + 2)
            continue;
        state_within(f, x, 0, y);
        m->indicate(s->k, y, y + s->n, f->t + x * f->h, scales, cubic.value, cubic.rate, cubic.size);
        for (int i = 0; i < count; i++)
            wrong[i] = fmax(wrong[i], WRONG * fabs(cubic.value[i] - at[k].value[i]));
    }
    for (int i = 0; i < count; i++) {
        double most = 0.0;
        for (int k = 0; k < EVENT_PARTS; k++)
            most = fmax(most, fabs(at[k + 1].value[i] - at[k].value[i]));
        for (int k = 0; k < EVENT_PARTS; k++)
            if (may_vanish(f, i, &at[k], &at[k + 1], most, wrong[i]))
                found |= (unsigned char)(1 << k);
    }
    give_back(s->arena, mark);
    return found;
}
