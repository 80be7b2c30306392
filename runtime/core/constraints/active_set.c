/* The active set; see active_set.h. */
#include "constraints/active_set.h"

#include <stdlib.h>
#include <string.h>

#include "algebra/semidefinite.h"

static size_t numbers_of(const struct ccgen_model *m)
{
    const size_t c = m->contacts, n = m->nu;
    return 2 * c * (6 * c + n + 3) + 5 * c + 2 * n + semidefinite_scratch(2 * (int)c);
}

int make_active_set(struct active_set *h, const struct ccgen_model *m)
{
    const size_t c = m->contacts, n = m->nu;
    memset(h, 0, sizeof *h);
    if (!c)
        return 0;
    h->set = calloc(3 * c, sizeof *h->set); /* states hold all of it */
    h->closed = calloc(2 * c, 1);
    h->force = calloc(numbers_of(m), sizeof *h->force);
    if (!h->set || !h->closed || !h->force)
        return 1;
    h->of = h->set + c;
    h->mode = (signed char *)h->closed + c;
    h->columns = h->force + 2 * c;
    h->W = h->columns + 2 * c * n;
    h->units = h->W + 4 * c * c;
    h->answers = h->units + 4 * c * c;
    h->wanted = h->answers + 4 * c * c;
    h->rates = h->wanted + 2 * c;
    h->slips = h->rates + c;
    h->pushes = h->slips + c;
    h->f = h->pushes + c;
    h->g = h->f + n;
    h->weight = h->g + n;
    h->least = h->weight + 2 * c;
    h->peak = h->least + c;
    h->solved = h->peak + c;
    return 0;
}

void free_active_set(struct active_set *h)
{
    free(h->set);
    free(h->closed);
    free(h->force);
}

void clear_active_set(struct active_set *h, const struct ccgen_model *m)
{
    h->count = h->rows = h->implied = 0;
    h->window = 0.0;
    if (!m->contacts)
        return;
    memset(h->set, 0, 3 * m->contacts * sizeof *h->set);
    memset(h->closed, 0, 2 * m->contacts); /* WATCHED, and no mode */
    memset(h->force, 0, numbers_of(m) * sizeof *h->force);
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
    for (int i = 0; i < h->rows; i++)
        h->weight[i] = 1.0;
}

void active_row(struct system *s, const double *q, int row, int friction, double *f)
{
    struct active_set *h = s->active;
    const struct ccgen_model *m = s->model;
    const int i = h->of[row], contact = h->set[i], slides = friction ? against(h->mode[i]) : 0;
    h->pushes[contact] = 1.0;
    (row < h->count ? m->contact_impulse : m->slip_impulse)(s->k, q, h->pushes, f);
    if (slides) {
        h->pushes[contact] = -slides * s->friction[contact];
        m->slip_impulse(s->k, q, h->pushes, h->g);
        for (int k = 0; k < s->n; k++)
            f[k] += h->g[k];
    }
    h->pushes[contact] = 0.0;
}

/* values[rows] of the normals and, for those that stick, of the tangents, from those of all contacts */
static void rows_of(const struct active_set *h, int rows, const double *normal, const double *tangent, double *values)
{
    for (int i = 0; i < rows; i++)
        values[i] = (i < h->count ? normal : tangent)[h->set[h->of[i]]];
}

int active_bias(struct system *s, const double *q, const double *u, double *bias)
{
    struct active_set *h = s->active;
    if (!active_count(s))
        return 0;
    s->model->gap_bias(s->k, q, u, h->rates);
    if (h->rows > h->count)
        s->model->slip_bias(s->k, q, u, h->slips);
    rows_of(h, h->rows, h->rates, h->slips, bias);
    return h->rows;
}
