/* Contacts that touch alike and part.
 *
 * Where a corner lies on the end of an edge the two bodies touch twice, the corner on the round end and the end on the edge of the corner. Both
 * gaps and both rows are one, but for the offset x to the side by which the corner lies beyond the end, whose radius is r: its gap is larger by x^2 / 2r, its normal
 * aslant by x / r. So the end bears, and the corner does not. The equations of contact do not say that: in W the difference is
 * (x / r)^2, which is rounding where x / r is none, and a corner that bore would push its body further to the side, with forces that grow as x does. It
 * shows in how gaps bend: moved to the side, that of the corner grows, that of the end is straight. Of two gaps that are one here, and whose
 * rates are, the one that bends up less is the smaller all around; where the corner comes to lie before the end, they change places.
 *
 * With w the difference of the rows, and d that of the second derivatives along a coordinate, rows are one where it is w / d away.
 *
 * Rough ones rub alike: they have one coefficient, and their tangential rows are one too.
 */
#include "constraints/twins.h"

#include <math.h>

#include "base/tolerances.h"
#include "model/contacts.h"

struct comparison {
    double whole, apart; /* squares of a row, and of the difference of both, in units */
    double d, w;         /* of the coordinate along which the gaps part most (m) */
    double bends;        /* how much both gaps bend along it (m) */
};

static void write_row(const struct system *s, const double *q, int contact, double *push, double *row)
{
    push[contact] = lever_of(s, contact);
    s->model->contact_impulse(s->k, q, push, row);
    push[contact] = 0.0;
}

static enum outcome compare(struct system *s, const double *q, int a, int b, struct comparison *found)
{
    const size_t contacts = s->model->contacts;
    const struct mark mark = s->arena->top;
    double *push = TAKE_ZEROS(s->arena, double, contacts), *u = TAKE_ZEROS(s->arena, double, s->n);
    double *one = TAKE(s->arena, double, s->n), *other = TAKE(s->arena, double, s->n);
    double *bias = TAKE(s->arena, double, contacts);
    const enum outcome outcome = s->arena->ran_out ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    *found = (struct comparison){0};
    if (!outcome) {
        write_row(s, q, a, push, one);
        write_row(s, q, b, push, other);
    }
    for (int i = 0; i < s->n && !outcome; i++) {
        const double unit = s->unit[i], w = (one[i] - other[i]) * unit;
        found->whole += one[i] * unit * (one[i] * unit);
        found->apart += w * w;
        u[i] = unit;
        contact_bias(s, q, u, bias);
        u[i] = 0.0;
        if (fabs(bias[a] - bias[b]) > fabs(found->d)) {
            found->d = bias[a] - bias[b];
            found->w = w;
            found->bends = fabs(bias[a]) + fabs(bias[b]);
        }
    }
    give_back(s->arena, mark);
    return outcome;
}

/* Whether gaps part that are alike: two feet of what is guided do not. */
static int part(const struct system *s, const struct comparison *c)
{
    return fabs(c->d) > BENDS_OTHERWISE * fmax(s->length, c->bends);
}

/* Whether what rubs at one does so at the other: smooth ones do */
static int rub_alike(struct system *s, const double *q, int a, int b)
{
    if (!s->friction || (s->friction[a] == 0.0 && s->friction[b] == 0.0))
        return 1;
    const struct mark mark = s->arena->top;
    double *push = TAKE_ZEROS(s->arena, double, s->model->contacts);
    double *one = TAKE(s->arena, double, s->n), *other = TAKE(s->arena, double, s->n);
    double whole = 0.0, apart = 0.0;
    const int comparable = !s->arena->ran_out && s->friction[a] == s->friction[b];
    if (comparable) {
        push[a] = 1.0;
        s->model->slip_impulse(s->k, q, push, one);
        push[a] = 0.0;
        push[b] = 1.0;
        s->model->slip_impulse(s->k, q, push, other);
    }
    for (int i = 0; i < s->n && comparable; i++) {
        const double size = one[i] * s->unit[i], w = (one[i] - other[i]) * s->unit[i];
        whole += size * size;
        apart += w * w;
    }
    give_back(s->arena, mark);
    return comparable && apart <= IMPLIED_SHARE * whole;
}

int twins_at(struct system *s, const double *q, int a, int b)
{
    struct comparison c;
    const enum outcome outcome = compare(s, q, a, b, &c);
    if (outcome || c.apart > IMPLIED_SHARE * c.whole || !part(s, &c) || !rub_alike(s, q, a, b))
        return 0;
    return c.d > 0.0 ? 1 : -1;
}

enum outcome twins_apart(struct system *s, const double *q, int a, int b, double *aside)
{
    struct comparison c;
    const enum outcome outcome = compare(s, q, a, b, &c);
    *aside = outcome || !part(s, &c) ? 0.0 : fabs(c.w) / c.d;
    return outcome;
}
