/* What held contacts do: forces that keep gaps closed in motion, impulses that close them in projection.
 *
 * A unit impulse along a row of N (the normal of a contact, or the tangent of one that sticks), loops held shut, changes the
 * velocities by a column of Y = M^-1 N^T, which the impulsive equations give. Forces P are those with
 *
 *     N u_dot + dN/dt u = N (u_dot_free + Y P) + dN/dt u = 0,    W P = -(N u_dot_free + dN/dt u),    W = N Y.
 *
 * Where a contact slides, its normal force brings friction with it: its column is that of N^T - mu sign(slip) T^T, and W is
 * no longer symmetric. Where W loses digits because contacts nearly depend on each other or on the closure, the caller
 * solves for both together on the robust path (docs/theory, section 8), with forces of least norm.
 */
#include "contact.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "elimination.h"

static const double WELL = 1e-6; /* a pivot below this fraction of what it was has lost too many digits */
/* times length per second: what moves along its friction is not at its limit; more than what settle.c takes as still */
static const double CREEP = 1e-9;

int make_holding(struct holding *h, const struct ccgen_model *m)
{
    const size_t c = m->contacts, n = m->nu;
    memset(h, 0, sizeof *h);
    if (!c)
        return 0;
    h->set = malloc(3 * c * sizeof *h->set);
    h->closed = calloc(2 * c, 1);
    h->force = calloc(2 * c * (6 * c + n + 3) + 5 * c + 2 * n + semidefinite_scratch(2 * (int)c), sizeof *h->force);
    if (!h->set || !h->closed || !h->force)
        return 1;
    h->of = h->set + c;
    h->slide = (signed char *)h->closed + c;
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

void free_holding(struct holding *h)
{
    free(h->set);
    free(h->closed);
    free(h->force);
}

void hold_contacts(struct holding *h, int count, const int *set, const signed char *slide)
{
    h->count = h->rows = count;
    for (int i = 0; i < count; i++) {
        h->set[i] = set[i];
        h->slide[i] = slide[i];
        h->of[i] = i;
    }
    for (int i = 0; i < count; i++)
        if (slide[i] == STICKS)
            h->of[h->rows++] = i;
    for (int i = 0; i < h->rows; i++)
        h->weight[i] = 1.0;
}

/* The same column by column, where the joined function has not solved or digits are refined */
static enum outcome compliance_by_columns(struct system *s, const double *q, int count, const int *set, double *columns,
                                          double *W, double *pushes, double *rates, double *f)
{
    const struct ccgen_model *m = s->model;
    const int all = s->friction ? 2 * count : count;
    memset(s->bias, 0, m->rows * sizeof *s->bias);
    memset(pushes, 0, m->contacts * sizeof *pushes);
    for (int j = 0; j < all; j++) {
        double *column = columns + (size_t)j * s->n;
        const int contact = set[j % count];
        pushes[contact] = 1.0;
        (j < count ? m->contact_impulse : m->slip_impulse)(s->k, q, pushes, f);
        pushes[contact] = 0.0;
        const enum outcome outcome = system_impulse(s, q, f, s->bias, NEAREST, column, s->multipliers);
        if (outcome)
            return outcome;
        for (int i = 0; i < all; i++) {
            if (i % count == 0)
                (i < count ? m->gap_rates : m->slips)(s->k, q, column, rates);
            W[i * all + j] = rates[set[i % count]];
        }
    }
    return OUTCOME_DONE;
}

enum outcome compliance(struct system *s, const double *q, int count, const int *set, double *columns, double *W,
                        double *units, double *answers, double *pushes, double *rates, double *f)
{
    const struct ccgen_model *m = s->model;
    const int all = s->friction ? 2 * count : count, width = width_of(s);
    int wrong = s->refine;
    if (!wrong) {
        memset(units, 0, (size_t)all * width * sizeof *units);
        for (int j = 0; j < all; j++)
            units[(size_t)j * width + set[j % count] + (j < count ? 0 : m->contacts)] = 1.0;
        wrong = m->contact_response(s->k, q, all, units, columns, answers);
        memset(units, 0, (size_t)all * width * sizeof *units);
    }
    for (int j = 0; j < all && !wrong; j++)
        for (int i = 0; i < all; i++)
            W[i * all + j] = answers[(size_t)j * width + set[i % count] + (i < count ? 0 : m->contacts)];
    const enum outcome outcome =
        wrong ? compliance_by_columns(s, q, count, set, columns, W, pushes, rates, f) : OUTCOME_DONE;
    for (int i = 0; i < all && !outcome; i++)
        for (int j = 0; j < i; j++)
            W[i * all + j] = W[j * all + i] = 0.5 * (W[i * all + j] + W[j * all + i]);
    return outcome;
}

void held_row(struct system *s, const double *q, int row, int friction, double *f)
{
    struct holding *h = s->holding;
    const struct ccgen_model *m = s->model;
    const int i = h->of[row], contact = h->set[i], slides = friction ? against(h->slide[i]) : 0;
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
static void rows_of(const struct holding *h, int rows, const double *normal, const double *tangent, double *values)
{
    for (int i = 0; i < rows; i++)
        values[i] = (i < h->count ? normal : tangent)[h->set[h->of[i]]];
}

/* x <- W^-1 x; 1 where W is nearly singular, 2 where its determinant is negative: friction then pushes harder the more it is
 * resisted, and a contact however stiff would not stay as it is. */
static int solve_sliding(int n, double *W, double *x)
{
    const int sign = eliminate(n, W, x, WELL);
    return sign > 0 ? 0 : sign < 0 ? 2 : 1;
}

/* Forces (impulses) whose columns bring the rates by wanted[rows] further, added to motion[n]; nonzero where they, or the
 * closure, are nearly dependent, or friction jams. */
static int push(struct system *s, const double *q, int rows, int friction, double *force, double *motion)
{
    struct holding *h = s->holding;
    const struct ccgen_model *m = s->model;
    const int width = width_of(s), c = m->contacts;
    int sliding = 0;
    for (int j = 0; j < rows; j++) {
        const int i = h->of[j], contact = h->set[i], slides = friction ? against(h->slide[i]) : 0;
        double *unit = h->units + (size_t)j * width;
        unit[j < h->count ? contact : c + contact] = 1.0;
        if (slides)
            unit[c + contact] = -slides * s->friction[contact];
        sliding |= slides;
    }
    const int lost = m->contact_response(s->k, q, rows, h->units, h->columns, h->answers);
    memset(h->units, 0, (size_t)rows * width * sizeof *h->units);
    if (lost)
        return 1;
    for (int j = 0; j < rows; j++)
        for (int i = 0; i < rows; i++)
            h->W[i * rows + j] = h->answers[(size_t)j * width + h->set[h->of[i]] + (i < h->count ? 0 : c)];
    const int wrong = sliding ? solve_sliding(rows, h->W, h->wanted) : solve_definite_well(rows, h->W, h->wanted, h->solved);
    if (wrong)
        return wrong;
    memcpy(force, h->wanted, rows * sizeof *force);
    for (int j = 0; j < rows; j++)
        for (int i = 0; i < s->n; i++)
            motion[i] += force[j] * h->columns[(size_t)j * s->n + i];
    return 0;
}

/* rates of the rows of a motion, less than which `wanted` has to be brought */
static void less_rates(struct system *s, const double *q, int rows, const double *motion)
{
    struct holding *h = s->holding;
    s->model->gap_rates(s->k, q, motion, h->rates);
    if (rows > h->count)
        s->model->slips(s->k, q, motion, h->slips);
    for (int i = 0; i < rows; i++)
        h->wanted[i] -= (i < h->count ? h->rates : h->slips)[h->set[h->of[i]]];
}

int hold_acceleration(struct system *s, const double *q, const double *u, double *u_dot)
{
    struct holding *h = s->holding;
    held_bias(s, q, u, h->wanted);
    for (int i = 0; i < h->rows; i++)
        h->wanted[i] = -h->wanted[i];
    less_rates(s, q, h->rows, u_dot);
    return push(s, q, h->rows, 1, h->force, u_dot);
}

int hold_jump(struct system *s, const double *q, int speed, const double *wanted, double *du)
{
    struct holding *h = s->holding;
    const int rows = held_rows(s, speed);
    memmove(h->wanted, wanted, rows * sizeof *wanted);
    less_rates(s, q, rows, du);
    return push(s, q, rows, 0, h->force, du);
}

int held_bias(struct system *s, const double *q, const double *u, double *bias)
{
    struct holding *h = s->holding;
    if (!holds(s))
        return 0;
    s->model->gap_bias(s->k, q, u, h->rates);
    if (h->rows > h->count)
        s->model->slip_bias(s->k, q, u, h->slips);
    rows_of(h, h->rows, h->rates, h->slips, bias);
    return h->rows;
}

/* watched values of a contact besides its force */
static int tangential(int slide)
{
    return slide == STICKS ? 2 : slide != SMOOTH && slide != TOUCHES;
}

int watched(const struct system *s)
{
    const struct holding *h = s->holding;
    int count = h ? h->count : 0;
    for (int i = 0; i < holds(s); i++)
        count += tangential(h->slide[i]);
    return count;
}

struct loss watcher(const struct system *s, int index)
{
    const struct holding *h = s->holding;
    if (index < h->count)
        return (struct loss){h->set[index], h->slide[index] == TOUCHES ? STIRS : PULLS};
    index -= h->count;
    for (int i = 0; i < h->count; i++) {
        const int values = tangential(h->slide[i]);
        if (index < values)
            return (struct loss){h->set[i], values == 1 ? STOPS : index ? GIVES_FORWARD : GIVES_BACKWARD};
        index -= values;
    }
    return (struct loss){-1, PULLS};
}

enum outcome watch(struct system *s, double t, const double *y, double *dy, double *values)
{
    const struct holding *h = s->holding;
    const enum outcome outcome = system_derivative(s, t, y, dy);
    int count = h->count, row = h->count;
    for (int i = 0; i < h->count && !outcome; i++)
        h->peak[h->set[i]] = fmax(h->peak[h->set[i]], fabs(h->force[i]));
    for (int i = 0; i < h->count; i++)
        values[i] = h->slide[i] == TOUCHES ? h->least[i] - fabs(h->force[i]) : h->least[i] + h->force[i];
    if (s->friction)
        s->model->slips(s->k, y, y + s->n, h->slips);
    for (int i = 0; i < h->count; i++) {
        const int contact = h->set[i];
        if (h->slide[i] == STICKS) {
            const double limit = s->friction[contact] * h->force[i], held = h->force[row++];
            values[count++] = limit - held; /* pulled forward no harder than that: it gives backward */
            values[count++] = limit + held;
        } else if (tangential(h->slide[i])) { /* at the limit it is at rest, or creeps against its friction */
            const double creeps = h->slide[i] == LIMIT || h->slide[i] == -LIMIT ? CREEP * s->length : 0.0;
            values[count++] = against(h->slide[i]) * h->slips[contact] + creeps;
        }
    }
    return outcome;
}
