/* Steps past singular configurations (docs/theory, section 8).
 *
 * At a distance sigma from a configuration where closure rows become dependent, the closure fixes one direction of the motion
 * to rounding / sigma only, velocities there to rounding / sigma^2, accelerations to rounding / sigma^3. What a stage of a
 * step near sigma = 0 gets wrong, the next stages make larger, until forces along the motion change too, which no estimate
 * shows. A step that passes such a configuration is therefore taken again with its length chosen so that the configuration
 * lies far from its stages, and with every stage put onto the closure first. The solution of the equations is the same, and
 * so is the order of the method.
 */
#include "passing.h"

#include <math.h>

#include "robust.h"

static const double BESIDE = 1.0;   /* times the tolerance: what the end of a step may miss the closure by */
static const double DEEP = 0.05;    /* how much nearer to dependence than elsewhere in the step rows come in passing */
static const double SHALLOW = 0.3;  /* the same at a first look */
static const double ALREADY = 0.1;  /* part of the step: a configuration as early as that lies behind */
static const double MIDDLE = 0.5;   /* part of the step that all methods' stages leave free */
enum { LOOKS = 8, ROUNDS = 4 };     /* each round looks at a quarter of the last one's part of the step */

/* Whether the end of the step lay beside the closure by more than its error may be, before it was put back to y1 */
static int beside(const struct flight *f)
{
    const struct system *s = f->s;
    const struct tolerance tolerance = f->run->tolerance;
    double speed = 0.0;
    for (int i = 0; i < s->n; i++)
        speed = fmax(speed, fabs(f->y1[s->n + i]));
    return s->missed_rate > BESIDE * (tolerance.atol + tolerance.rtol * speed) * s->length
           || s->missed > BESIDE * (tolerance.atol + tolerance.rtol) * s->length;
}

/* Coordinates at part x of the step, on the cubic through its beginning and `end` */
static void between_ends(const struct flight *f, const double *end, double x, double *q)
{
    const int n = f->s->n;
    for (int i = 0; i < n; i++) {
        const double change = end[i] - f->y[i], a = f->h * f->y[n + i] - change, b = change - f->h * end[n + i];
        q[i] = f->y[i] + x * (change + (1.0 - x) * ((1.0 - x) * a + x * b));
    }
}

int passes_singular(struct flight *f, enum outcome back, const double *end)
{
    if (!projects(f) || !f->s->model->rows || !(back || beside(f)))
        return 0;
    double least = INFINITY, most = 0.0, width = 1.0, low = 0.0;
    for (int round = 0; round < ROUNDS; round++) {
        for (int j = 0; j <= LOOKS; j++) {
            const double x = fmin(fmax(low + width * j / LOOKS, 0.0), 1.0);
            between_ends(f, end, x, f->search);
            const double here = nearest_row(f->s, f->search);
            most = fmax(most, here);
            if (here < least) {
                least = here;
                f->singular = x;
            }
        }
        if (!(least < SHALLOW * most))
            return 0;
        low = f->singular - width / LOOKS;
        width *= 2.0 / LOOKS;
    }
    return least < DEEP * most;
}

enum outcome guided_step(struct flight *f, double *error)
{
    const double part = f->singular;
    if (part > MIDDLE) /* first a step that ends well before it */
        f->h *= part - MIDDLE;
    else if (part > ALREADY)
        f->h *= part / MIDDLE;
    f->s->guided = 1;
    const enum outcome outcome = raw_step(f, f->h, f->run->tolerance);
    f->s->guided = 0;
    return outcome ? outcome : measure(f, error);
}
