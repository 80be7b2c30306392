/* The switching functions of held contacts; see switching.h. */
#include "motion/switching.h"

#include <float.h>
#include <math.h>

#include "base/tolerances.h"
#include "constraints/branch.h"
#include "constraints/shared_forces.h"
#include "constraints/twins.h"
#include "model/contacts.h"
#include "motion/derivative.h"

/* watched values of a contact besides its force */
static int tangential(int mode)
{
    return mode == STICK ? 2 : mode != FRICTIONLESS && mode != GRAZING;
}

/* Whether the sliding of a held contact is watched: of those that stick it is zero */
static int watches_slips(const struct active_set *h)
{
    for (int i = 0; i < h->count; i++)
        if (tangential(h->mode[i]) == 1)
            return 1;
    return 0;
}

/* How many contacts are carried by one that touches as they do */
static int twin_count(const struct system *s)
{
    int count = 0;
    for (int c = 0; active_count(s) && s->active->implied && c < s->model->contacts; c++)
        count += has_twin(s->active, c);
    return count;
}

int switching_count(const struct system *s)
{
    const struct active_set *h = s->active;
    int count = h ? h->count : 0;
    for (int i = 0; i < active_count(s); i++)
        count += tangential(h->mode[i]);
    return count + twin_count(s);
}

/* How far each carried twin is from where it bears, and what that is known to, values[twin_count], in the order of contacts */
static enum outcome twin_values(struct system *s, const double *q, double *values)
{
    const struct active_set *h = s->active;
    const int any = twin_count(s) > 0;
    enum outcome outcome = OUTCOME_DONE;
    for (int c = 0, k = 0; any && c < s->model->contacts && !outcome; c++)
        if (has_twin(h, c)) {
            outcome = twins_apart(s, q, c, h->twin[c], &values[k]);
            values[k++] += SHUT;
        }
    return outcome;
}

struct mode_change mode_change_of(const struct system *s, int index)
{
    const struct active_set *h = s->active;
    if (index < h->count)
        return (struct mode_change){h->set[index], h->mode[index] == GRAZING ? LOADS : DETACHES};
    index -= h->count;
    for (int i = 0; i < h->count; i++) {
        const int values = tangential(h->mode[i]);
        if (index < values)
            return (struct mode_change){h->set[i], values == 1 ? SLIP_ENDS : index ? SLIPS_FORWARD : SLIPS_BACKWARD};
        index -= values;
    }
    for (int c = 0; c < s->model->contacts; c++)
        if (has_twin(h, c) && index-- == 0)
            return (struct mode_change){c, BEARS};
    return (struct mode_change){-1, DETACHES};
}

/* values[] of forces that are not the only ones, and pull or pass Coulomb's limits, <- infinity, which changes no mode, where others give the same motion within the law. A
 * decision says that there are such forces, not that those of least norm, which the motion takes, are among them. */
static enum outcome keep_what_others_keep(struct system *s, const double *y, const double *dy, double *values)
{
    const struct active_set *h = s->active;
    const int contacts = s->model->contacts;
    const struct mark mark = s->arena->top;
    double *push = TAKE_ZEROS(s->arena, double, 2 * (size_t)contacts);
    char *kept = TAKE_ZEROS(s->arena, char, contacts);
    int passes = 0;
    enum outcome outcome = s->arena->ran_out ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    for (int i = 0, row = h->count; i < h->count && !outcome; i++) {
        const int c = h->set[i], sticks = h->mode[i] == STICK;
        const double P = h->force[i], mu = s->friction ? s->friction[c] : 0.0;
        push[c] = P * lever_of(s, c);
        push[contacts + c] = sticks ? h->force[row++] : -against(h->mode[i]) * mu * P;
        passes |= h->mode[i] != GRAZING && (P < 0.0 || (sticks && fabs(push[contacts + c]) > mu * P));
    }
    if (passes)
        outcome = share_pushes(s, y, y + s->n, dy + s->n, PASSES_LAW, push, kept);
    for (int i = 0, next = h->count; i < h->count && passes && !outcome; i++) {
        const int keeps = kept[h->set[i]] && h->mode[i] != GRAZING;
        if (keeps)
            values[i] = INFINITY;
        if (keeps && h->mode[i] == STICK)
            values[next] = values[next + 1] = INFINITY;
        next += tangential(h->mode[i]);
    }
    give_back(s->arena, mark);
    return outcome;
}

enum { ROUNDINGS = 2 }; /* m u^2 is twice the kinetic energy */

/* Directions are known to eps / sigma there, and bend as fast as 1 / sigma. */
double missed_force(const struct system *s, const double *y)
{
    double energy[2];
    if (!passes_by(s))
        return 0.0;
    const double margin = nearest_margin(s);
    s->model->energy(s->k, y, y + s->n, energy);
    return ROUNDINGS * DBL_EPSILON / (margin * margin) * energy[0] / s->length;
}

enum outcome switching_functions(struct system *s, double t, const double *y, double *dy, double *values)
{
    const struct active_set *h = s->active;
    const struct mark mark = s->arena->top;
    double *slips = TAKE(s->arena, double, s->model->contacts);
    if (s->arena->ran_out) {
        give_back(s->arena, mark);
        return OUTCOME_NO_MEMORY;
    }
    enum outcome outcome = system_derivative(s, t, y, dy);
    int count = h->count, row = h->count;
    for (int i = 0; i < h->count && !outcome; i++)
        h->peak[h->set[i]] = fmax(h->peak[h->set[i]], fabs(h->force[i]));
    const double missed = h->count ? missed_force(s, y) : 0.0;
    for (int i = 0; i < h->count; i++)
        values[i] = fmax(missed, h->least[i]) + (h->mode[i] == GRAZING ? -fabs(h->force[i]) : h->force[i]);
    if (watches_slips(h))
        s->model->slips(s->k, y, y + s->n, slips);
    for (int i = 0; i < h->count; i++) {
        const int contact = h->set[i];
        if (h->mode[i] == STICK) {
            const double limit = s->friction[contact] * h->force[i], held = h->force[row++];
            values[count++] = limit - held; /* pulled forward no harder than that: it gives backward */
            values[count++] = limit + held;
        } else if (tangential(h->mode[i])) { /* at the limit it is at rest, or creeps against its friction */
            const double creeps =
                h->mode[i] == AT_LIMIT_FORWARD || h->mode[i] == AT_LIMIT_BACKWARD ? CREEP * s->length / s->time : 0.0;
            values[count++] = against(h->mode[i]) * slips[contact] + creeps;
        }
    }
    if (!outcome && h->count && h->open)
        outcome = keep_what_others_keep(s, y, dy, values);
    outcome = outcome ? outcome : twin_values(s, y, values + count);
    give_back(s->arena, mark);
    return outcome;
}
