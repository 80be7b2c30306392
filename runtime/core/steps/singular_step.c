/* Steps past singular configurations (docs/theory, section 8).
 *
 * At a distance sigma from a configuration where closure rows become dependent, the closure fixes one direction of the motion
 * to rounding / sigma only, velocities there to rounding / sigma^2, accelerations to rounding / sigma^3. What a stage of a
 * step near sigma = 0 gets wrong, the next stages make larger, until forces along the motion change too, which no estimate
 * shows; what the end of a step gets wrong, the next step makes larger. Steps near such a configuration are therefore placed:
 * one that would end beside it ends well before it, and the next passes it between two of its stages, with every stage put
 * onto the closure first, by a method that looks at neither of its ends: collocation (gauss.c). A state that an event or the
 * end of a run has left beside the configuration is passed over likewise. Another method's steps are too short for that: they would end
 * beside the configuration before they come in sight of it, and estimate rounding. Collocation takes over before, with steps as long
 * and as exact as a run by collocation would have there, and the run's own method goes on where velocities are known
 * to the tolerance again. The solution of the equations is the same, and so is the order of the method.
 */
#include "steps/singular_step.h"

#include <float.h>
#include <math.h>

#include "base/tolerances.h"
#include "constraints/nullspace.h"

static const double NEARLY = 1e-6; /* relative: what the length of a step need not be changed by */
enum { LOOKS = 8, ROUNDS = 4 };    /* each round looks at a quarter of the last one's part of the step */

/* Parts of a step at which a configuration is farthest from the stages of collocation: before the first one, and halfway between
 * two. The last is for steps that end at an event alone: a configuration that lies later than the last but one is approached by a
 * step of its own. */
static const double CLEAR[] = {0.005, 0.0608, 0.1695, 0.3228, 0.5, 0.6772, 0.8305, 0.9392};
enum { CLEARS = sizeof CLEAR / sizeof *CLEAR - 1 };
static const double MIDDLE = 0.5, LATE = 0.9;

/* What velocities of state y may be wrong by (1/s) */
static double rate_allowed(const struct phase *f, const double *y)
{
    return f->run->tolerance.atol / f->s->time + f->run->tolerance.rtol * fastest(f->s, y + f->s->n);
}

/* How near to dependence rows are where velocities of state y are just known to the tolerance */
static double doubtful_margin(const struct phase *f, const double *y)
{
    return sqrt(ACROSS_KNOWN * DBL_EPSILON * fastest(f->s, y + f->s->n) / rate_allowed(f, y));
}

/* Whether the end of the step lay beside the closure by more than its error may be, before it was put back to y1 */
static int off_the_closure(const struct phase *f)
{
    const struct system *s = f->s;
    return s->missed_rate > BESIDE * rate_allowed(f, f->y1) * s->length ||
           s->missed > BESIDE * (f->run->tolerance.atol + f->run->tolerance.rtol) * s->length;
}

/* Whether rows are so near to dependence at the end of the step that velocities are not known to the tolerance there, nearer than `near`.
 * Putting a state back from such a place changes its velocities by 1 / sigma times what they missed: looked at only where they changed by a good
 * part of that, and by more than far from singular configurations. */
static int unsure(const struct phase *f)
{
    const struct system *s = f->s;
    const double moved = s->moved_rate * s->length;
    if (!(moved > MAGNIFIED * s->missed_rate))
        return 0;
    const double near = doubtful_margin(f, f->y1);
    return MAGNIFIED * near * moved > s->missed_rate && rank_margin(f->s, f->y1) < near;
}

/* Whether the step is so short that it could begin where velocities are not known to the tolerance before a look ahead has found the place */
static int could_begin_in_doubt(const struct phase *f)
{
    return LOOK_AHEAD * f->h * fastest(f->s, f->y + f->s->n) < fmin(doubtful_margin(f, f->y), SIGMA_DROP);
}

/* Whether it does. Away from passages rows may be as near as that to dependence for long, which the run's own method bears. */
static int begins_in_doubt(const struct phase *f)
{
    return !active_count(f->s) && rank_margin(f->s, f->y) < fmin(doubtful_margin(f, f->y), SIGMA_DROP);
}

/* Whether the step may have passed dependence without a sign: its stages lay on the closure, or its method damps what they had
 * wrong. The angle between two links changes by no more than twice the fastest rotation; rows come no faster nearer to dependence. */
static int may_hide(const struct phase *f)
{
    return (f->at.passage == ABOUT || f->by->damps) &&
           rank_margin(f->s, f->y1) < 2.0 * LOOK_AHEAD * f->h * fastest(f->s, f->y1 + f->s->n);
}

void between_ends(const struct phase *f, double h, const double *end, double x, double *q)
{
    const int n = f->s->n;
    for (int i = 0; i < n; i++) {
        const double change = end[i] - f->y[i], a = h * f->y[n + i] - change, b = change - h * end[n + i];
        q[i] = f->y[i] + x * (change + (1.0 - x) * ((1.0 - x) * a + x * b));
    }
}

double margin_below(const struct phase *f, int rank, const double *q)
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

int crosses_singularity(struct phase *f, enum outcome back, double error, const double *end)
{
    double part;
    if (!projects(f) || !f->s->model->rows || f->run->fixed_step > 0.0)
        return 0;
    if (!(back || error > WILD || off_the_closure(f) || may_hide(f) || (error <= 1.0 && unsure(f))) ||
        !nearest_part(f, end, LOOK_AHEAD, &part))
        return 0;
    f->at.place = f->t + part * f->h;
    return 1;
}

int misplaced(struct phase *f, const double *end)
{
    double part;
    if (f->at.passage != ACROSS || !nearest_part(f, end, 1.0, &part) ||
        fabs(f->t + part * f->h - f->at.place) < PLACED * f->h)
        return 0;
    f->at.place = f->t + part * f->h;
    return 1;
}

/* How many times as long as those of the run's own method steps by collocation are. A method of order p misses about (h / T)^p in a step, T being
 * how far the motion is analytic: with the tolerance for that, h = T rtol^(1/p). */
static double times_as_long(const struct phase *f)
{
    return pow(f->run->tolerance.rtol, 1.0 / gauss.order - 1.0 / f->run->method->order);
}

int keeps_collocation(struct phase *f)
{
    const enum passage was = f->at.passage;
    if (!f->passing || was == FREE)
        return 0;
    const int keeps = begins_in_doubt(f);
    if (!keeps && was != BEFORE)
        f->h = fmin(f->h, f->at.own);
    return keeps;
}

int begins_beside_singularity(struct phase *f)
{
    return f->passing && could_begin_in_doubt(f) && begins_in_doubt(f);
}

/* Stages of a method that are not put back miss the closure by its error, and move by 1 / sigma times that: towards a singular configuration its
 * steps become shorter in proportion to what is left of the way, and never come in sight of it by looking ahead as far as they are long. */
int leads_to_singularity(struct phase *f)
{
    const struct system *s = f->s;
    if (!f->passing || f->at.passage != FREE || active_count(s) || !projects(f))
        return 0;
    const double near = fmin(doubtful_margin(f, f->y1), SIGMA_DROP);
    if (!(MAGNIFIED * near * s->moved_rate * s->length > s->missed_rate))
        return 0;
    const double after = rank_margin(f->s, f->y1);
    if (!(after < near))
        return 0;
    const double before = rank_margin(f->s, f->y);
    return after < before && before < LOOK_AHEAD * times_as_long(f) * (before - after);
}

int ends_near_dependence(struct phase *f)
{
    struct system *s = f->s;
    if (!f->branch.chart || !projects(f) || !(MAGNIFIED * BRIDGED * s->moved_rate * s->length > s->missed_rate))
        return 0;
    return is_beside_place(f, f->y1);
}

void take_over(struct phase *f, double own)
{
    f->at.own = own;
    f->h *= times_as_long(f);
    if (f->h >= f->at.longest) {
        f->h = f->at.longest;
        f->at.bounded = 1;
    }
}

int passes_place(const struct phase *f, double h)
{
    return f->at.passage == ACROSS && f->at.place - f->t <= CLEAR[CLEARS - 1] * h;
}

/* The first of CLEAR[count] between two stages at which a configuration at that part may lie in a shorter step, or in this one; 0 where none is */
static double next_clear(double part, int count)
{
    for (int i = 1; i < count; i++)
        if (part <= CLEAR[i] * (1.0 + NEARLY))
            return CLEAR[i];
    return 0.0;
}

/* The same of a step of that length that ends at an event, in a run by collocation. By another method the rest of the way, in short steps of its own,
 * would begin where less is known. */
static double clear_before_event(const struct phase *f, double part)
{
    return f->passing || f->at.passage != ACROSS || !(part > CLEAR[0]) ? 0.0 : next_clear(part, CLEARS + 1);
}

double clear_landing(const struct phase *f, double length)
{
    const double until = f->at.place - f->t, clear = clear_before_event(f, until / length);
    return until / length < clear * (1.0 - NEARLY) ? until / clear : 0.0;
}

int lies_clear(const struct phase *f, double length)
{
    const double part = (f->at.place - f->t) / length, clear = clear_before_event(f, part);
    return clear > 0.0 && part >= clear * (1.0 - NEARLY);
}

double between_stages(double part)
{
    return next_clear(part, CLEARS);
}

void place_about_singularity(struct phase *f, enum passage elsewhere)
{
    const double part = (f->at.place - f->t) / f->h;
    f->at.passage = elsewhere;
    if (!(part > -CLEAR[0] &&
          part < 1.0 + MIDDLE)) /* not where no place is known, or where a whole step before it leaves enough */
        return;
    f->at.passage = ACROSS;
    if (part < CLEAR[0])
        return;
    const double clear = next_clear(part, CLEARS);
    if (clear > 0.0) {
        f->h *= part / clear;
        return;
    }
    if (f->at.bounded && part > LATE) /* it has to end there */
        return;
    f->at.passage = BEFORE; /* so that it lies in the middle of the next, which is as long as this might have been */
    f->h *= f->at.bounded ? (part - MIDDLE) / MIDDLE : part - MIDDLE;
}
