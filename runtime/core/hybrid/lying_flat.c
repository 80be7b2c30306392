/* Where a loop of many links falls flat, bounces end at a place at which its closure rows are dependent, and no branch passes: the tip of a cone.
 * Nearer to it than the root of rounding, places do not tell which side of the tip they are on (docs/theory, eq. 8.3), and no
 * step gets further. What is left of the motion would lift the loop by no more than that, and is taken by one impact.
 */
#include "hybrid/lying_flat.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "algebra/dot.h"
#include "base/tolerances.h"
#include "constraints/impulse.h"
#include "constraints/nullspace.h"
#include "impact/impact.h"
#include "motion/projection.h"
#include "model/contacts.h"

/* The contacts with gaps that are not known from none, f->set: how many, or 0 where all are closed already, or one of them bounces for ever */
static int find_lying(struct phase *f, double unknown)
{
    const struct system *s = f->s;
    int count = 0, open = 0;
    contact_gaps(s, f->y, f->gaps);
    for (int c = 0; c < s->model->contacts; c++)
        if (f->gaps[c] <= unknown * s->extent[c]) {
            open |= f->gaps[c] > SHUT * s->extent[c];
            if (!(s->restitution[c] < 1.0))
                return 0;
            f->set[count++] = c;
        }
    return open ? count : 0;
}

/* Put y1, a copy of the state, where the contacts f->set are closed and at rest, and rows of the closure are dependent. Whether that is a place
 * of the mechanism. */
static int is_put_down(struct phase *f, int count, int rank)
{
    struct system *s = f->s;
    double nearest;
    if (project_position(s, f->y1) || row_rank(s, f->y1, &nearest) >= rank)
        return 0;
    contact_gaps(s, f->y1, f->gaps);
    for (int c = 0; c < s->model->contacts; c++)
        if (!(f->gaps[c] >= -SHUT * s->extent[c]))
            return 0;
    for (int i = 0; i < count; i++)
        if (f->gaps[f->set[i]] > SHUT * s->extent[f->set[i]])
            return 0;
    return !project_velocity(s, f->y1, f->y1 + s->n);
}

/* The energy (J) that is lost from the state to y1 */
static double lost(const struct phase *f)
{
    const struct system *s = f->s;
    double before[2], behind[2];
    s->model->energy(s->k, f->y, f->y + s->n, before);
    s->model->energy(s->k, f->y1, f->y1 + s->n, behind);
    return before[0] - behind[0] + (before[1] - behind[1]);
}

/* The kinetic energy (J) of the change of velocities to y1; without drives it is what is lost of that */
static double jumped(const struct phase *f)
{
    struct system *s = f->s;
    const struct mark mark = s->arena->top;
    double *du = TAKE(s->arena, double, s->n), *momentum = TAKE(s->arena, double, s->n), found = INFINITY;
    if (!s->arena->ran_out) {
        jump_loss(s, f->y, f->y + s->n, f->y1 + s->n, du, momentum);
        found = 0.5 * dot(s->n, du, momentum);
    }
    give_back(s->arena, mark);
    return found;
}

static enum outcome go_on_from_there(struct phase *f, int count, double loss)
{
    const size_t n = f->s->n;
    const struct mark mark = f->s->arena->top;
    double *P = TAKE_ZEROS(f->s->arena, double, 2 * (size_t)count);
    enum outcome outcome = f->s->arena->ran_out || record_state(f) ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    if (!outcome && append_impact(&f->run->impacts, f->t, f->y + n, f->y1 + n, n, count, f->set, P, loss, 0.0,
                                  f->run->record.count))
        outcome = OUTCOME_NO_MEMORY;
    give_back(f->s->arena, mark);
    memcpy(f->y, f->y1, (size_t)f->s->size * sizeof *f->y);
    return outcome ? outcome : record_state(f) ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
}

/* Put down, with what is held put aside: whether the loop can be. */
static int puts_down(struct phase *f, int count, int rank, enum outcome *outcome)
{
    struct system *s = f->s;
    struct active_set *h = s->active;
    const size_t contacts = s->model->contacts;
    const int held = h->count;
    const struct mark mark = s->arena->top;
    int *set = TAKE(s->arena, int, contacts), down = 0;
    signed char *mode = TAKE(s->arena, signed char, contacts);
    signed char *smooth = TAKE_ZEROS(s->arena, signed char, contacts); /* FRICTIONLESS */
    *outcome = s->arena->ran_out ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    if (!*outcome) {
        memcpy(set, h->set, held * sizeof *set);
        memcpy(mode, h->mode, held);
        memcpy(f->y1, f->y, (size_t)s->size * sizeof *f->y);
        activate(h, count, f->set, smooth);
        down = is_put_down(f, count, rank);
        activate(h, held, set, mode);
        if (interrupted(s->interruption, 0))
            *outcome = OUTCOME_INTERRUPTED;
    }
    give_back(s->arena, mark);
    return down && !*outcome;
}

enum outcome lay_flat(struct phase *f, int *contact)
{
    struct system *s = f->s;
    const double unknown = sqrt(DBL_EPSILON);
    double nearest, parts[2];
    *contact = -1;
    if (!s->rows_on || !s->model->contacts)
        return OUTCOME_DONE;
    const int rank = row_rank(s, f->y, &nearest), beside = f->branch.rank + s->model->drives;
    const int lost_already = f->branch.rank && rank < beside;
    const int count = lost_already || nearest <= unknown ? find_lying(f, unknown) : 0;
    enum outcome outcome = OUTCOME_DONE;
    if (!count || !puts_down(f, count, lost_already ? rank + 1 : rank, &outcome))
        return outcome;
    s->model->energy(s->k, f->y, f->y + s->n, parts);
    const double loss = lost(f), most = unknown * fmax(f->at.energy_in_motion, parts[0]);
    if (!(loss >= (s->model->drives ? -most : 0.0) && loss <= most && jumped(f) <= most))
        return OUTCOME_DONE;
    *contact = f->set[0];
    return go_on_from_there(f, count, loss);
}
