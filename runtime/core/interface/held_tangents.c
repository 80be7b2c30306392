/* Derivatives of accelerations with contacts held (docs/theory, eq. 11.6): to those with the forces of the contacts held in value and
 * place comes what these forces change by, so that the rows of the contacts stay shut. */
#include "interface/held_tangents.h"

#include <math.h>
#include <string.h>

#include "algebra/inverse.h"
#include "base/tolerances.h"
#include "constraints/active_set.h"

/* The forces of the contacts as unknowns: those along the normal first, then those along the ground of what sticks */
struct problem {
    int count, rows;                /* contacts, and forces */
    size_t n, every, lanes, blocks; /* numbers of a block: every = (n + closure rows) lanes */
    double *row, *column;           /* [rows][n] what each force keeps, and what it pushes along */
    double *slip;                   /* [count][n] rows along the ground */
    double *f;                      /* [blocks][n + rows of closure][lanes] what contacts push otherwise, forces held */
    double *moved, *answer;         /* as f; [blocks of columns][..][lanes] what f, and each column, accelerates by */
    double *missed;                 /* [blocks][rows][lanes] what rows move by, forces held */
    double *matrix, *inverse;       /* [rows][rows] from forces to rates of their rows, and back */
    double *z, *left;               /* [rows][lanes] changes of force, and what they leave */
    double *unit;                   /* [contacts] zeros */
    double *part;                   /* [blocks][n or contacts][lanes] of one function */
};

static size_t larger(size_t a, size_t b)
{
    return a > b ? a : b;
}

static int take_problem(struct system *s, struct held held, size_t blocks, struct problem *p)
{
    const struct ccgen_model *m = s->model;
    const size_t n = s->n, lanes = m->derivatives->lanes, every = (n + m->rows) * lanes;
    int rows = held.count;
    for (int i = 0; i < held.count; i++)
        rows += held.mode[i] == STICK;
    const size_t columns = (rows + lanes - 1) / lanes, r = rows, c = held.count;
    struct arena *arena = s->arena;
    *p = (struct problem){.count = held.count,
                          .rows = rows,
                          .n = n,
                          .every = every,
                          .lanes = lanes,
                          .blocks = blocks,
                          .row = TAKE(arena, double, (r * n)),
                          .column = TAKE(arena, double, (r * n)),
                          .slip = TAKE(arena, double, (c * n)),
                          .f = TAKE_ZEROS(arena, double, (larger(blocks, columns) * every)),
                          .moved = TAKE(arena, double, (blocks * every)),
                          .answer = TAKE(arena, double, (columns * every)),
                          .missed = TAKE_ZEROS(arena, double, (blocks * r * lanes)),
                          .matrix = TAKE(arena, double, (r * r)),
                          .inverse = TAKE(arena, double, (r * r)),
                          .z = TAKE(arena, double, (r * lanes)),
                          .left = TAKE(arena, double, (r * lanes)),
                          .unit = TAKE_ZEROS(arena, double, (size_t)m->contacts),
                          .part = TAKE(arena, double, (blocks * larger(n, m->contacts) * lanes))};
    return arena->ran_out;
}

/* The sign of friction at its limit along the ground, by the normal force and the coefficient; 0 of what is not there */
static int rubs(struct held held, int i)
{
    return -against(held.mode[i]);
}

/* Rows and columns of the contacts; 0 where friction is not what it is at its limit */
static int write_contacts(struct system *s, const struct pushed *at, struct held held, struct problem *p)
{
    const struct ccgen_model *m = s->model;
    const size_t n = p->n;
    for (int i = 0, tangential = p->count; i < p->count; i++) {
        const int contact = held.set[i], sign = rubs(held, i);
        double *row = p->row + i * n, *column = p->column + i * n, *slip = p->slip + i * n;
        p->unit[contact] = 1.0;
        m->contact_impulse(s->k, at->q, p->unit, row);
        if (m->slip_impulse)
            m->slip_impulse(s->k, at->q, p->unit, slip);
        p->unit[contact] = 0.0;
        memcpy(column, row, n * sizeof *row);
        if (held.mode[i] == STICK) {
            memcpy(p->row + tangential * n, slip, n * sizeof *slip);
            memcpy(p->column + tangential++ * n, slip, n * sizeof *slip);
        }
        if (!sign)
            continue;
        const double limit = sign * s->friction[contact] * at->push[contact], rub = at->push[m->contacts + contact];
        if (!(fabs(rub - limit) <= FRICTION_MISSED * fmax(fabs(rub), fabs(limit))))
            return 0;
        for (size_t j = 0; j < n; j++)
            column[j] += sign * s->friction[contact] * slip[j];
    }
    return 1;
}

/* The tangents of one function into p->part; 0 where it does not move */
static int move(struct system *s, const char *name, struct ccgen_arguments at, const struct ccgen_arguments *by,
                struct problem *p)
{
    const struct ccgen_named_tangent *of = find_tangent(s->model, name);
    if (of)
        of->function(&at, by, (int)p->blocks, p->part);
    return of != NULL;
}

/* Add p->part, [blocks][n][lanes], to f */
static void add_push(struct problem *p)
{
    for (size_t b = 0; b < p->blocks; b++)
        for (size_t i = 0; i < p->n * p->lanes; i++)
            p->f[b * p->every + i] += p->part[b * p->n * p->lanes + i];
}

/* What contacts push otherwise with their forces held, and where friction slides with another coefficient */
static void write_pushes(struct system *s, const struct pushed *at, struct held held, const struct whole_directions *by,
                         struct problem *p)
{
    const struct ccgen_model *m = s->model;
    const size_t lanes = p->lanes, contacts = m->contacts;
    const double *rub = at->push + contacts;
    struct ccgen_arguments here = {.k = s->k, .q = at->q, .u = at->u, .t = &at->t, .inputs = s->inputs, .P = at->push};
    int any = 0, slides = 0;
    if (move(s, "contact_impulse", here, &by->still, p))
        add_push(p);
    for (int i = 0; i < held.count; i++) {
        any |= rub[held.set[i]] != 0.0;
        slides |= rubs(held, i);
    }
    here.P = rub;
    if (any && move(s, "slip_impulse", here, &by->still, p))
        add_push(p);
    if (!slides || !move(s, "friction", here, &by->still, p))
        return;
    for (int i = 0; i < held.count; i++)
        for (size_t b = 0; b < p->blocks && rubs(held, i); b++)
            for (size_t j = 0; j < p->n * lanes; j++)
                p->f[b * p->every + j] += rubs(held, i) * at->push[held.set[i]] * p->slip[i * p->n + j / lanes] *
                                          p->part[(b * contacts + held.set[i]) * lanes + j % lanes];
}

/* Add p->part, [blocks][contacts][lanes], of the contacts of rows from `first` on */
static void add_missed(const struct system *s, struct held held, int along, struct problem *p)
{
    const size_t lanes = p->lanes, contacts = s->model->contacts;
    for (size_t b = 0; b < p->blocks; b++)
        for (int i = 0, row = along ? p->count : 0; i < p->count; i++) {
            if (along && held.mode[i] != STICK)
                continue;
            const double *from = p->part + (b * contacts + held.set[i]) * lanes;
            double *to = p->missed + (b * p->rows + row++) * lanes;
            for (size_t l = 0; l < lanes; l++)
                to[l] += from[l];
        }
}

/* What the accelerations of the contacts, N u_dot + dN/dt u, move by with u_dot held */
static void write_missed(struct system *s, const struct pushed *at, struct held held, const struct whole_directions *by,
                         struct problem *p)
{
    static const char *const names[2][2] = {{"gap_rates", "gap_bias"}, {"slips", "slip_bias"}};
    struct ccgen_arguments here = {.k = s->k, .q = at->q, .t = &at->t, .inputs = s->inputs, .P = at->push};
    for (int along = 0; along < (p->rows > p->count ? 2 : 1); along++)
        for (int bias = 0; bias < 2; bias++) {
            here.u = bias ? at->u : at->u_dot;
            if (move(s, names[along][bias], here, bias ? &by->all : &by->still, p))
                add_missed(s, held, along, p);
        }
}

/* Number i of column j among blocks of columns */
static double *entry(const struct problem *p, double *blocks, size_t i, size_t j)
{
    return blocks + j / p->lanes * p->every + i * p->lanes + j % p->lanes;
}

/* What the pushes and each of the columns accelerate by; f is then used up */
static enum outcome respond(struct system *s, const double *q, struct problem *p)
{
    const size_t columns = (p->rows + p->lanes - 1) / p->lanes;
    const enum outcome outcome = impulse_tangents(s, q, (int)p->blocks, p->f, p->moved);
    if (outcome)
        return outcome;
    memset(p->f, 0, columns * p->every * sizeof *p->f);
    for (int j = 0; j < p->rows; j++)
        for (size_t i = 0; i < p->n; i++)
            *entry(p, p->f, i, j) = p->column[j * p->n + i];
    return impulse_tangents(s, q, (int)columns, p->f, p->answer);
}

/* The matrix from forces to rates of their rows, and its inverse; 0 where it may be singular */
static int invert(struct system *s, struct problem *p)
{
    const size_t r = p->rows;
    const struct mark mark = s->arena->top;
    double *scratch = TAKE(s->arena, double, (r * (2 * r + 2)));
    for (size_t i = 0; i < r; i++)
        for (size_t j = 0; j < r; j++) {
            double sum = 0.0;
            for (size_t l = 0; l < p->n; l++)
                sum += p->row[i * p->n + l] * *entry(p, p->answer, l, j);
            p->matrix[i * r + j] = sum;
        }
    const int sure = scratch && invert_sure((int)r, p->matrix, SURELY_INDEPENDENT, p->inverse, scratch);
    give_back(s->arena, mark);
    return sure;
}

/* y[rows][lanes] += sign times matrix[rows][count] x[count][lanes] */
static void add_product(size_t rows, size_t count, size_t lanes, double sign, const double *matrix, const double *x,
                        double *y)
{
    for (size_t i = 0; i < rows; i++)
        for (size_t j = 0; j < count; j++)
            for (size_t l = 0; l < lanes; l++)
                y[i * lanes + l] += sign * matrix[i * count + j] * x[j * lanes + l];
}

/* Add what the contacts do: pushes that are otherwise, and changes of force that keep the rows shut, to rounding: what the inverse
 * leaves is solved for again, as forces of light links may be large */
static void add_contacts(struct problem *p, double *tangents)
{
    const size_t lanes = p->lanes, r = p->rows;
    for (size_t b = 0; b < p->blocks; b++) {
        double *found = tangents + b * p->every, *missed = p->missed + b * r * lanes;
        for (size_t j = 0; j < p->n * lanes; j++)
            found[j] += p->moved[b * p->every + j];
        add_product(r, p->n, lanes, 1.0, p->row, found, missed);
        memset(p->z, 0, r * lanes * sizeof *p->z);
        add_product(r, r, lanes, 1.0, p->inverse, missed, p->z);
        memcpy(p->left, missed, r * lanes * sizeof *missed);
        add_product(r, r, lanes, -1.0, p->matrix, p->z, p->left);
        add_product(r, r, lanes, 1.0, p->inverse, p->left, p->z);
        for (size_t i = 0; i < r; i++)
            for (size_t j = 0; j < p->n; j++)
                for (size_t l = 0; l < lanes; l++)
                    found[j * lanes + l] -= *entry(p, p->answer, j, i) * p->z[i * lanes + l];
    }
}

enum outcome held_tangents(struct system *s, const struct pushed *at, struct held held,
                           const struct whole_directions *by, double *tangents, int *sure)
{
    const struct mark mark = s->arena->top;
    struct problem p;
    double missed = -1.0;
    *sure = 1;
    enum outcome outcome =
        acceleration_tangents(s, at->t, at->q, at->u, at->u_dot, at->multipliers, by->along, tangents, &missed);
    if (!outcome && held.count && take_problem(s, held, by->along->blocks, &p))
        outcome = OUTCOME_NO_MEMORY;
    *sure = missed < 0.0;
    if (!outcome && *sure && held.count && (*sure = write_contacts(s, at, held, &p))) {
        write_pushes(s, at, held, by, &p);
        write_missed(s, at, held, by, &p);
        outcome = respond(s, at->q, &p);
        if (!outcome && (*sure = invert(s, &p)))
            add_contacts(&p, tangents);
    }
    give_back(s->arena, mark);
    return outcome;
}
