/* The active set; see active_set.h. */
#include "constraints/active_set.h"
#include "model/contacts.h"

#include <string.h>

int take_active_set(struct arena *arena, struct active_set *h, const struct ccgen_model *m)
{
    const size_t c = m->contacts;
    *h = (struct active_set){
        .set = TAKE(arena, int, c),
        .mode = TAKE(arena, signed char, c),
        .of = TAKE(arena, int, 2 * c),
        .force = TAKE(arena, double, 2 * c),
        .least = TAKE(arena, double, c),
        .peak = TAKE(arena, double, c),
        .closed = TAKE(arena, char, c),
        .twin = TAKE(arena, int, c),
    };
    if (arena->ran_out)
        return 1;
    clear_active_set(h, m);
    return 0;
}

void clear_active_set(struct active_set *h, const struct ccgen_model *m)
{
    const size_t c = m->contacts;
    h->count = h->rows = h->implied = h->open = 0;
    h->window = 0.0;
    memset(h->set, 0, c * sizeof *h->set); /* states hold all of it */
    memset(h->mode, 0, c * sizeof *h->mode);
    memset(h->of, 0, 2 * c * sizeof *h->of);
    memset(h->force, 0, 2 * c * sizeof *h->force);
    memset(h->least, 0, c * sizeof *h->least);
    memset(h->peak, 0, c * sizeof *h->peak);
    memset(h->closed, WATCHED, c * sizeof *h->closed);
    for (size_t i = 0; i < c; i++)
        h->twin[i] = -1;
}

void copy_active_set(struct active_set *to, const struct active_set *from, int contacts)
{
    const size_t c = contacts;
    to->count = from->count;
    to->rows = from->rows;
    to->implied = from->implied;
    to->open = from->open;
    to->window = from->window;
    memcpy(to->set, from->set, c * sizeof *to->set);
    memcpy(to->mode, from->mode, c * sizeof *to->mode);
    memcpy(to->of, from->of, 2 * c * sizeof *to->of);
    memcpy(to->force, from->force, 2 * c * sizeof *to->force);
    memcpy(to->least, from->least, c * sizeof *to->least);
    memcpy(to->peak, from->peak, c * sizeof *to->peak);
    memcpy(to->closed, from->closed, c * sizeof *to->closed);
    memcpy(to->twin, from->twin, c * sizeof *to->twin);
}

void contact_modes(const struct active_set *h, int contacts, signed char *modes)
{
    for (int c = 0; c < contacts; c++)
        modes[c] = h->closed[c] == CARRIED ? IMPLIED : OPEN;
    for (int i = 0; i < h->count; i++)
        modes[h->set[i]] = h->mode[i];
}

void activate(struct active_set *h, int count, const int *set, const signed char *mode)
{
    h->count = h->rows = count;
    for (int i = 0; i < count; i++) {
        h->set[i] = set[i];
        h->mode[i] = mode[i];
        h->of[i] = i;
    }
    for (int i = 0; i < count; i++)
        if (mode[i] == STICK)
            h->of[h->rows++] = i;
}

void active_row(const struct system *s, const double *q, int row, double *push, double *f)
{
    const struct active_set *h = s->active;
    const struct ccgen_model *m = s->model;
    const int contact = h->set[h->of[row]];
    push[contact] = row < h->count ? lever_of(s, contact) : 1.0;
    (row < h->count ? m->contact_impulse : m->slip_impulse)(s->k, q, push, f);
    push[contact] = 0.0;
}

/* values[rows] of the normals and, for those that stick, of the tangents, from those of all contacts */
static void rows_of(const struct active_set *h, int rows, const double *normal, const double *tangent, double *values)
{
    for (int i = 0; i < rows; i++)
        values[i] = (i < h->count ? normal : tangent)[h->set[h->of[i]]];
}

void bias_of_active(const struct system *s, const double *q, const double *u, double *rates, double *slips,
                    double *bias)
{
    const struct active_set *h = s->active;
    if (!active_count(s))
        return;
    contact_bias(s, q, u, rates);
    if (h->rows > h->count)
        s->model->slip_bias(s->k, q, u, slips);
    rows_of(h, h->rows, rates, slips, bias);
}

void rates_of_active(const struct system *s, const double *q, const double *u, int rows, double *rates, double *slips,
                     double *found)
{
    const struct active_set *h = s->active;
    contact_rates(s, q, u, rates);
    if (rows > h->count)
        s->model->slips(s->k, q, u, slips);
    rows_of(h, rows, rates, slips, found);
}
