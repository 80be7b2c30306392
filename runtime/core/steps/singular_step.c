/* Where steps come near dependent rows of the closure (docs/theory, section 8).
 *
 * Elsewhere the closure tells where a step leads. A step that comes near a place where it does not is taken again, along the branch of the closure on
 * which the motion is (constraints/branch.c).
 */
#include "steps/singular_step.h"

#include <math.h>

#include "base/tolerances.h"
#include "constraints/nullspace.h"
#include "methods/gauss.h"

enum { LOOKS = 8, ROUNDS = 4 }; /* each round looks at a quarter of the last one's part of the step */

/* Whether the end of the step lay beside the closure by more than its error may be, before it was put back to y1 */
static int off_the_closure(const struct phase *f)
{
    const struct system *s = f->s;
    const double atol = f->run->tolerance.atol, rtol = f->run->tolerance.rtol;
    return s->missed_rate > BESIDE * (atol / s->time + rtol * fastest(s, f->y1 + s->n)) * s->length ||
           s->missed > BESIDE * (atol + rtol) * s->length;
}

/* Putting a state back from near such a place changes its velocities by 1 / sigma times what they missed, or leaves out rows that depend nowhere else: looked at
 * only where it changed them by a good part of that, or more rows were left out than depend everywhere. */
int ends_near_dependence(struct phase *f)
{
    const struct system *s = f->s;
    const int everywhere = f->branch.rank ? s->rows_on - f->branch.rank : 0;
    return f->branch.chart && projects(f) &&
           (s->left_out > everywhere || MAGNIFIED * BRIDGED * s->moved_rate * s->length > s->missed_rate) &&
           is_beside_place(f, f->y1);
}

/* Whether the step may have passed dependence without a sign, as its method damps what stages have wrong across the closure. The angle between two links
 * changes by no more than twice the fastest rotation; rows come no faster nearer to dependence. */
static int may_hide(const struct phase *f)
{
    return f->by->damps && rank_margin(f->s, f->y1) < 2.0 * LOOK_AHEAD * f->h * fastest(f->s, f->y1 + f->s->n);
}

/* Coordinates q[n] at part x of a step of length h to end[2n], on the cubic through its ends */
static void between_ends(const struct phase *f, double h, const double *end, double x, double *q)
{
    const int n = f->s->n;
    for (int i = 0; i < n; i++) {
        const double change = end[i] - f->y[i], a = h * f->y[n + i] - change, b = change - h * end[n + i];
        q[i] = f->y[i] + x * (change + (1.0 - x) * ((1.0 - x) * a + x * b));
    }
}

/* How near to dependence rows are at q[n], 0 where fewer than `rank` count: of rows that depend none is near */
static double margin_below(const struct phase *f, int rank, const double *q)
{
    double margin;
    return row_rank(f->s, q, &margin) < rank ? 0.0 : margin;
}

/* The part of the step, up to `last`, at which the cubic comes nearest to dependence; whether rows depend there. q[n] is scratch. */
static int look_for_nearest(struct phase *f, const double *end, double last, double *q, double *part)
{
    double least = INFINITY, most, width = last, low = 0.0;
    const int rank = row_rank(f->s, f->y, &most);
    for (int round = 0; round < ROUNDS; round++) {
        for (int j = 0; j <= LOOKS; j++) {
            const double x = fmin(fmax(low + width * j / LOOKS, 0.0), last);
            between_ends(f, f->h, end, x, q);
            const double here = margin_below(f, rank, q);
            most = fmax(most, here);
            if (here < least) {
                least = here;
                *part = x;
            }
        }
        if (!(least < SIGMA_DROP_COARSE * most))
            return 0;
        low = *part - width / LOOKS;
        width *= 2.0 / LOOKS;
    }
    return least < SIGMA_DROP * most;
}

int nearest_part(struct phase *f, const double *end, double last, double *part)
{
    struct arena *arena = f->s->arena;
    const struct mark mark = arena->top;
    double *q = TAKE(arena, double, f->s->n);
    const int found = !arena->ran_out && look_for_nearest(f, end, last, q, part);
    give_back(arena, mark);
    return found;
}

int comes_near_dependence(struct phase *f, enum outcome back, double error, const double *end)
{
    double part;
    if (!f->branch.chart || !projects(f) || f->run->fixed_step > 0.0)
        return 0;
    if (!back && ends_near_dependence(f))
        return 1;
    return (back || error > WILD || off_the_closure(f) || may_hide(f)) && nearest_part(f, end, LOOK_AHEAD, &part);
}

void take_over(struct phase *f, double own)
{
    /* A method of order p misses about (h / T)^p in a step, T being how far the motion is analytic: with the tolerance for that, h = T rtol^(1/p) */
    const double times_as_long = pow(f->run->tolerance.rtol, 1.0 / gauss.order - 1.0 / f->run->method->order);
    f->h = fmin(own * times_as_long, f->at.longest);
    f->at.bounded |= f->h == f->at.longest;
}
