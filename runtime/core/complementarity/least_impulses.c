/* The least of all impulses with which Coulomb's law holds at rough contacts.
 *
 * Ways whose systems are singular are left out: where impulses
 * are not unique, those without superfluous ones remain, as the corners of a linear program. Of consistent ways that of least
 * normal impulses is taken: at a mechanism of one freedom, where sliding and approach end together and any larger impulse
 * could be held by friction, it is where the process of the impact ends.
 *
 * Ways are thousands where contacts are seven, and nearly all pull at some contact, or push more than others do. That is seen
 * from a factorisation that ways with the same beginning share (bordered.h); what is not seen there is solved by itself.
 */
#include "complementarity/least_impulses.h"

#include <math.h>
#include <string.h>

#include "base/tolerances.h"
#include "complementarity/bordered.h"
#include "complementarity/ways.h"

enum { MOST = 50000 }; /* ways: at six contacts all, also in expansion */

/* Which kinds contact i may be of, in a motion with the scaled rates vn and vt where `known`: their number */
static int kinds_of(const struct friction_problem *c, int i, int known, double vn, double vt, signed char *kinds)
{
    const int bound = c->least && c->least[i] > 0.0, free = c->rough[i] && !c->slides[i];
    const int slides = known && fabs(vt) > CONSISTENT, against = (vt < 0.0) == (c->bt[i] < 0.0);
    int count = 0;
    for (int kind = 0; kind < KINDS; kind++) {
        const int stays = kind < LEAST_ON, on = kind == ON || kind == LEAST_ON;
        if ((known && stays && vn > CONSISTENT) || (!free && !on) || (!stays && !bound && !on))
            continue;
        if (free && slides && (stays || bound) && (holds_fast(kind) || on != against))
            continue;
        kinds[count++] = (signed char)kind;
    }
    return count;
}

/* Whether impulses move as the rates do: 0 where not. */
static int same_motion(const struct friction_problem *c, const double *Pn, const double *Pt, const double *rates)
{
    const double speed = sizes_of(c, Pn, Pt).speed;
    double size;
    for (int row = 0; row < 2 * c->n; row++)
        if (fabs(rate_of(c, row, Pn, Pt, &size) - rates[row]) > ALIKE * (size + speed * c->root[row]))
            return 0;
    return 1;
}

/* Whether impulses add energy to the motion that has the rates c->from. */
static int adds(const struct friction_problem *c, const double *Pn, const double *Pt)
{
    const int n = c->n;
    double gain = 0.0, all = 0.0;
    for (int i = 0; c->from && i < 2 * n; i++) {
        const double P = i < n ? Pn[i] : Pt[i - n];
        double change = 0.0, size = 0.0;
        for (int j = 0; j < 2 * n; j++) {
            const double term = c->W[(size_t)i * 2 * n + j] * (j < n ? Pn[j] : Pt[j - n]);
            change += term;
            size += fabs(term);
        }
        gain += P * (c->from[i] + 0.5 * change);
        all += fabs(P) * (fabs(c->from[i]) + 0.5 * size);
    }
    return gain > RATE_ROUNDING * all;
}

struct search {
    double *A, *x, *Pn, *Pt, *rates;
    int *column, *count, *turn;
    signed char *kinds, *way;
    struct bordered bordered;
};

/* Whether what rests in a known motion could push and be held in one way only: then so do the impulses. */
static int unique(const struct friction_problem *c, struct search *s)
{
    for (int i = 0; i < c->n; i++) {
        const signed char *kinds = s->kinds + i * KINDS;
        s->way[i] = kinds[0];
        for (int k = 0; k < s->count[i]; k++)
            s->way[i] = kinds[k] == HELD_FAST ? HELD_FAST : s->way[i];
    }
    return !impulses_of_way(c, s->way, s->A, s->x, s->column, s->Pn, s->Pt);
}

/* Whether no contact pulls, but for rounding: a part of `coulomb_residual` that most ways already break */
static int none_pulls(const struct friction_problem *c, const double *Pn, const double *Pt)
{
    const double load = sizes_of(c, Pn, Pt).load;
    for (int i = 0; i < c->n; i++)
        if (c->root[i] * (Pn[i] - (c->least ? c->least[i] : 0.0)) < -CONSISTENT * load)
            return 0;
    return 1;
}

/* Whether impulses s->Pn and s->Pt of the way keep the law, and have a motion that is `known` */
static int is_consistent(const struct friction_problem *c, const struct search *s, int known)
{
    return none_pulls(c, s->Pn, s->Pt) && coulomb_residual(c, s->Pn, s->Pt) <= CONSISTENT && !adds(c, s->Pn, s->Pt) &&
           (!known || same_motion(c, s->Pn, s->Pt, s->rates));
}

/* All ways, the last contact's changing fastest; the best so far is in Pn and Pt, where `found`. */
static int try_all(const struct friction_problem *c, struct search *s, int known, int found, double *Pn, double *Pt)
{
    const int n = c->n;
    double least = found ? loaded(c, Pn) : INFINITY;
    memset(s->turn, 0, n * sizeof *s->turn);
    for (int changed = 0; changed >= 0;) { /* the first contact whose turn has come */
        enum beginning beginning = SOUND;
        for (; changed < n && beginning != SINGULAR; changed++) {
            s->way[changed] = s->kinds[changed * KINDS + s->turn[changed]];
            beginning = border(c, s->way, changed, &s->bordered);
        }
        if (beginning != SINGULAR && !is_ruled_out(c, s->way, least, &s->bordered) &&
            !impulses_of_way(c, s->way, s->A, s->x, s->column, s->Pn, s->Pt) &&
            (!found || loaded(c, s->Pn) < (1.0 - LESS) * least) && is_consistent(c, s, known)) {
            memcpy(Pn, s->Pn, n * sizeof *Pn);
            memcpy(Pt, s->Pt, n * sizeof *Pt);
            least = loaded(c, Pn);
            found = 1;
        }
        changed--; /* what begins like a singular way is passed over */
        while (changed >= 0 && ++s->turn[changed] == s->count[changed])
            s->turn[changed--] = 0;
    }
    return found;
}

int least_impulses(const struct friction_problem *c, enum known given, double *Pn, double *Pt)
{
    const size_t n = c->n;
    const int known = given == MOTION;
    const struct mark mark = c->arena->top;
    struct search s = {
        .A = TAKE(c->arena, double, 4 * n * n),
        .x = TAKE(c->arena, double, 2 * n),
        .Pn = TAKE(c->arena, double, n),
        .Pt = TAKE(c->arena, double, n),
        .rates = TAKE(c->arena, double, 2 * n),
        .column = TAKE(c->arena, int, 2 * n),
        .count = TAKE(c->arena, int, n),
        .turn = TAKE(c->arena, int, n),
        .kinds = TAKE_ZEROS(c->arena, signed char, (KINDS * n)),
        .way = TAKE(c->arena, signed char, n),
    };
    double size;
    long ways = 1;
    int result = 2;
    if (c->arena->ran_out || take_bordered(c, &s.bordered))
        goto end;
    const struct sizes of = known ? sizes_of(c, Pn, Pt) : (struct sizes){0.0, 0.0, 0.0};
    for (int i = 0; i < c->n; i++) {
        const double vn = known ? scaled_rate(c, i, Pn, Pt, &of) : 0.0;
        const double vt = known ? scaled_rate(c, c->n + i, Pn, Pt, &of) : 0.0;
        s.count[i] = kinds_of(c, i, known, vn, vt, s.kinds + i * KINDS);
        ways *= ways <= MOST ? s.count[i] : 1;
    }
    for (int row = 0; known && row < 2 * c->n; row++)
        s.rates[row] = rate_of(c, row, Pn, Pt, &size);
    if (known && unique(c, &s))
        result = 0;
    else if (ways <= MOST)
        result = !try_all(c, &s, known, given != NOTHING, Pn, Pt);
end:
    give_back(c->arena, mark);
    return result;
}
