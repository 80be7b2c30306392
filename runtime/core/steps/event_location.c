/* Landing on events; see event_location.h. */
#include "steps/event_location.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "base/tolerances.h"
#include "steps/step_end.h"
#include "motion/sides.h"
#include "motion/switching.h"
#include "model/contacts.h"

enum { LANDINGS = 60 }; /* steps towards an event; three to five are usual */

/* Step again from (t, y) so that the step ends at the event: Newton on the gap, kept inside the bracket of what is known.
 * y1 is then the state at t + h, as accurate as any step's end. */
static enum outcome locate_gap_event(struct phase *f, struct event event)
{
    double h = event.theta * f->h, before = 0.0, behind = f->h;
    for (int i = 0; f->t + h > f->t; i++) {
        const enum outcome outcome = projected_step(f, h);
        if (outcome)
            return outcome;
        contact_gaps(f->s, f->y1, f->gaps);
        contact_rates(f->s, f->y1, f->y1 + f->s->n, f->rates);
        const double g = f->gaps[event.contact], rate = f->rates[event.contact];
        const double resolution = DBL_EPSILON * fmax(f->t + h, f->h);
        if (g > 0.0)
            before = h;
        else
            behind = h;
        double next = rate < 0.0 ? h - g / rate : h;
        if (fabs(next - h) <= resolution || behind - before <= resolution || i == LANDINGS) {
            const int landed = rate < 0.0 && fabs(next - h) <= resolution; /* as near as the time can tell */
            const int behind_it = g < -PENETRATION * f->s->extent[event.contact] && before < h;
            const int deep = behind_it && !landed; /* the gap may jump: stay outside */
            f->h = deep ? before : h;
            return deep ? projected_step(f, f->h) : OUTCOME_DONE;
        }
        h = next > before && next < behind ? next : 0.5 * (before + behind);
    }
    memcpy(f->y1, f->y, (size_t)f->s->size * sizeof *f->y); /* the event is where the step begins */
    f->h = 0.0;
    return OUTCOME_DONE;
}

/* Watched values of held contacts at (t, y), */
static enum outcome watch_contacts(struct phase *f, double t, const double *y, double *value)
{
    return switching_functions(f->s, t, y, f->dy1, value);
}

/* and those of effects with kinks */
static enum outcome watch_effects(struct phase *f, double t, const double *y, double *value)
{
    return side_functions(f->s, t, y, f->s->sides, value);
}

typedef enum outcome watched_values(struct phase *f, double t, const double *y, double *value);

/* The same for a watched value: false position with the Illinois modification, and halves where a value is infinite. value[watched] is scratch. */
static enum outcome locate_sign_change(struct phase *f, struct event event, watched_values *watch, double *value)
{
    double low = 0.0, high = event.behind * f->h, h = event.theta * f->h;
    enum outcome outcome =
        event.behind < 1.0 ? projected_step(f, high) : OUTCOME_DONE; /* it may be positive again at the end */
    outcome = outcome ? outcome : watch(f, f->t + high, f->y1, value);
    const double end = value[event.watch];
    outcome = outcome ? outcome : watch(f, f->t, f->y, value);
    double at_low = value[event.watch], at_twice = NAN;
    for (int i = 0;
         !outcome && at_low <= 0.0 && event.theta > 0.0 && !falls_from_zero(at_low, at_twice) && i < LANDINGS;
         i++) { /* zero at first, then positive */
        low = ldexp(h, -i - 1);
        at_twice = i ? at_low : NAN;
        outcome = projected_step(f, low);
        outcome = outcome ? outcome : watch(f, f->t + low, f->y1, value);
        at_low = value[event.watch];
    }
    if (outcome)
        return outcome;
    double at_high = end < 0.0 ? end : -at_low, lost = end;
    const double jump = JUMP * at_low;
    for (int i = 0, side = 0; !outcome && at_low > 0.0 && f->t + h > f->t; i++) {
        if ((outcome = projected_step(f, h)) || (outcome = watch(f, f->t + h, f->y1, value)))
            return outcome;
        const double now = value[event.watch];
        if (now > 0.0) {
            low = h;
            at_low = now;
            at_high *= side > 0 ? 0.5 : 1.0;
            side = 1;
        } else {
            high = h;
            at_high = lost = now;
            at_low *= side < 0 ? 0.5 : 1.0;
            side = -1;
        }
        if (high - low <= DBL_EPSILON * fmax(f->t + h, f->h) || now == 0.0 || i == LANDINGS) {
            const int before = now >= jump && lost < 0.0; /* past the end of an edge a force jumps: not lost before */
            f->h = before ? high : h;
            return before ? projected_step(f, high) : OUTCOME_DONE;
        }
        h = (low * at_high - high * at_low) / (at_high - at_low);
        if (!(h > low && h < high))
            h = 0.5 * (low + high);
    }
    memcpy(f->y1, f->y, (size_t)f->s->size * sizeof *f->y);
    f->h = 0.0;
    return outcome;
}

enum outcome locate_event(struct phase *f, struct event event)
{
    struct arena *arena = f->s->arena;
    if (event.watch == CLOSES)
        return locate_gap_event(f, event);
    const struct mark mark = arena->top;
    double *value = TAKE(arena, double, switching_count(f->s));
    const enum outcome outcome =
        arena->ran_out ? OUTCOME_NO_MEMORY : locate_sign_change(f, event, watch_contacts, value);
    give_back(arena, mark);
    return outcome;
}

enum outcome locate_kink(struct phase *f, struct event event)
{
    struct arena *arena = f->s->arena;
    const struct mark mark = arena->top;
    double *value = TAKE(arena, double, f->s->model->switches);
    const enum outcome outcome =
        arena->ran_out ? OUTCOME_NO_MEMORY : locate_sign_change(f, event, watch_effects, value);
    give_back(arena, mark);
    return outcome;
}
