/* What held contacts do: forces that keep gaps closed in motion, impulses that close them in projection.
 *
 * A unit impulse along a row of N (the normal of a contact, or the tangent of one that sticks), loops held shut, changes the
 * velocities by a column of Y = M^-1 N^T, which the impulsive equations give. Forces P are those with
 *
 *     N u_dot + dN/dt u = N (u_dot_free + Y P) + dN/dt u = 0,    W P = -(N u_dot_free + dN/dt u),    W = N Y.
 *
 * Where a contact slides, its normal force brings friction with it: its column is that of N^T - mu sign(slip) T^T, and W is
 * no longer symmetric. Where contacts depend on each other, as the feet of a table, P is that of least norm, and so it is where rows of the closure depend on each other too:
 * the columns are then those of the null-space path. Where W loses digits because contacts nearly depend on each
 * other or on the closure, the caller solves for both together on the robust path (docs/theory, section 8).
 */
#include "constraints/contact_forces.h"

#include <math.h>
#include <string.h>

#include "algebra/dependent.h"
#include "algebra/elimination.h"
#include "algebra/semidefinite.h"
#include "base/tolerances.h"
#include "model/contacts.h"

/* x <- W^-1 x; 1 where W is nearly singular, 2 where its determinant is negative: friction then pushes harder the more it is
 * resisted, and a contact however stiff would not stay as it is. */
static int solve_sliding(int n, double *W, double *x)
{
    const int sign = eliminate(n, W, x, CONTACT_PIVOT);
    return sign > 0 ? 0 : sign < 0 ? 2 : 1;
}

/* What the forces of the rows are worked out from */
struct problem {
    double *units;         /* [rows][width of a column] unit forces, a column for each row */
    double *columns;       /* [rows][n] motion that each gives, loops held shut */
    double *answers;       /* [rows][width of a column] rates of all contacts that it gives */
    double *W;             /* [rows][rows] rates of the rows */
    double *whole;         /* [rows][rows] the same, for who needs it again */
    double *weight;        /* [rows] one over the norm of what pushes with a row */
    double *scratch;       /* [rows][rows] of the solution */
    double *wanted;        /* [rows] rates that are to be brought about; then the forces that do it */
    double *found;         /* [rows] rates of the motion without them */
    double *rates, *slips; /* [contacts] of all contacts */
};

/* 0, or 1 when memory runs out */
static int take_problem(const struct system *s, size_t rows, struct problem *p)
{
    const size_t width = width_of(s), contacts = s->model->contacts;
    struct arena *arena = s->arena;
    p->units = TAKE_ZEROS(arena, double, (rows * width));
    p->columns = TAKE(arena, double, rows * s->n);
    p->answers = TAKE(arena, double, (rows * width));
    p->W = TAKE(arena, double, (rows * rows));
    p->whole = TAKE(arena, double, (rows * rows));
    p->weight = TAKE(arena, double, rows);
    p->scratch = TAKE(arena, double, (rows * rows));
    p->wanted = TAKE(arena, double, rows);
    p->found = TAKE(arena, double, rows);
    p->rates = TAKE(arena, double, contacts);
    p->slips = TAKE(arena, double, contacts);
    return arena->ran_out;
}

/* p->wanted <- the forces that bring it about; of contacts that depend on each other, but not nearly, and let the closure be, those of least norm: *open. Nonzero
 * as `push` says */
static int solve_sticking_or_shared(struct system *s, int rows, struct problem *p, int friction, int *open)
{
    *open = 0;
    if (!solve_definite_well(rows, p->W, p->wanted, p->scratch))
        return 0;
    if (!friction || solve_dependent(s->arena, rows, p->W, p->wanted, p->weight, p->scratch))
        return 1;
    memcpy(p->wanted, p->scratch, rows * sizeof *p->wanted);
    *open = 1;
    return 0;
}

/* The same where some slide */
static int solve_sliding_or_shared(struct system *s, int rows, struct problem *p, int *open)
{
    const size_t all = (size_t)rows * rows;
    memcpy(p->whole, p->W, all * sizeof *p->W);
    memcpy(p->scratch, p->wanted, rows * sizeof *p->wanted);
    const int wrong = solve_sliding(rows, p->W, p->wanted);
    *open = wrong == 1;
    return wrong == 1 ? solve_dependent(s->arena, rows, p->whole, p->scratch, p->weight, p->wanted) : wrong;
}

/* p->units and p->weight; whether one slides */
static int set_units(const struct system *s, int rows, int friction, struct problem *p)
{
    const struct active_set *h = s->active;
    const int width = width_of(s), c = s->model->contacts;
    int sliding = 0;
    for (int j = 0; j < rows; j++) {
        const int i = h->of[j], contact = h->set[i], slides = friction ? against(h->mode[i]) : 0;
        double *unit = p->units + (size_t)j * width;
        unit[j < h->count ? contact : c + contact] = j < h->count ? lever_of(s, contact) : 1.0;
        p->weight[j] = 1.0;
        if (slides) {
            unit[c + contact] = -slides * s->friction[contact];
            p->weight[j] = 1.0 / hypot(1.0, s->friction[contact]);
        }
        sliding |= slides;
    }
    return sliding;
}

/* h->force <- the forces that bring the rates by p->wanted[rows] further, what they do being added to motion[n]; nonzero as `push` says */
static int solve_and_add(struct system *s, int rows, int friction, int sliding, struct problem *p, double *motion)
{
    struct active_set *h = s->active;
    const int wrong = sliding ? solve_sliding_or_shared(s, rows, p, &h->open)
                              : solve_sticking_or_shared(s, rows, p, friction, &h->open);
    if (wrong)
        return wrong;
    memcpy(h->force, p->wanted, rows * sizeof *h->force);
    for (int j = 0; j < rows; j++)
        for (int i = 0; i < s->n; i++)
            motion[i] += h->force[j] * p->columns[(size_t)j * s->n + i];
    return 0;
}

/* Forces (impulses) whose columns bring the rates by p->wanted[rows] further, added to motion[n]; nonzero where they, or the
 * closure, are nearly dependent, or friction jams. */
static int push(struct system *s, const double *q, int rows, int friction, struct problem *p, double *motion)
{
    const struct active_set *h = s->active;
    const struct ccgen_model *m = s->model;
    const int width = width_of(s), c = m->contacts, sliding = set_units(s, rows, friction, p);
    if (m->contact_response(s->k, q, rows, p->units, p->columns, p->answers))
        return 1;
    for (int j = 0; j < rows; j++)
        for (int i = 0; i < rows; i++)
            p->W[i * rows + j] = p->answers[(size_t)j * width + h->set[h->of[i]] + (i < h->count ? 0 : c)] *
                                 (i < h->count ? lever_of(s, h->set[i]) : 1.0);
    return solve_and_add(s, rows, friction, sliding, p, motion);
}

/* Less the rates of the rows that the motion has already */
static void less_rates(const struct system *s, const double *q, int rows, const double *motion, struct problem *p)
{
    rates_of_active(s, q, motion, rows, p->rates, p->slips, p->found);
    for (int i = 0; i < rows; i++)
        p->wanted[i] -= p->found[i];
}

int add_contact_accelerations(struct system *s, const double *q, const double *u, double *u_dot)
{
    const int rows = active_rows(s, 1);
    const struct mark mark = s->arena->top;
    struct problem p;
    int wrong = take_problem(s, rows, &p);
    if (!wrong) {
        bias_of_active(s, q, u, p.rates, p.slips, p.wanted);
        for (int i = 0; i < rows; i++)
            p.wanted[i] = -p.wanted[i];
        less_rates(s, q, rows, u_dot, &p);
        wrong = push(s, q, rows, 1, &p, u_dot);
    }
    give_back(s->arena, mark);
    return wrong;
}

/* The columns of all rows, one by one, by motions that rows which count leave: p->columns, p->W, and the multipliers Lambda[rows][closure rows] that go with each;
 * f[n] and more[n] are scratch. */
static void respond_in_nullspace(struct system *s, const double *q, int rows, struct nullspace *flight,
                                 struct problem *p, double *Lambda, double *f, double *more)
{
    const struct ccgen_model *m = s->model;
    for (int j = 0; j < rows; j++) {
        const double *unit = p->units + (size_t)j * width_of(s);
        double *column = p->columns + (size_t)j * s->n;
        m->contact_impulse(s->k, q, unit, f);
        if (s->friction) {
            m->slip_impulse(s->k, q, unit + m->contacts, more);
            for (int i = 0; i < s->n; i++)
                f[i] += more[i];
        }
        choose_jump(s, flight, f, column, Lambda + (size_t)j * m->rows);
        rates_of_active(s, q, column, rows, p->rates, p->slips, p->found);
        for (int i = 0; i < rows; i++)
            p->W[i * rows + j] = p->found[i];
    }
}

int add_contact_accelerations_in_nullspace(struct system *s, const double *q, const double *u, struct nullspace *flight,
                                           double *u_dot, double *lambda)
{
    const int rows = active_rows(s, 1);
    const size_t n = s->n, closed = s->model->rows;
    const struct mark mark = s->arena->top;
    struct problem p;
    double *Lambda = TAKE(s->arena, double, rows *closed), *f = TAKE(s->arena, double, n),
           *more = TAKE(s->arena, double, n);
    int wrong = take_problem(s, rows, &p);
    if (!wrong) {
        bias_of_active(s, q, u, p.rates, p.slips, p.wanted);
        for (int i = 0; i < rows; i++)
            p.wanted[i] = -p.wanted[i];
        less_rates(s, q, rows, u_dot, &p);
        const int sliding = set_units(s, rows, 1, &p);
        respond_in_nullspace(s, q, rows, flight, &p, Lambda, f, more);
        wrong = solve_and_add(s, rows, 1, sliding, &p, u_dot);
    }
    for (int j = 0; j < rows && !wrong; j++)
        for (size_t i = 0; i < closed; i++)
            lambda[i] += s->active->force[j] * Lambda[(size_t)j * closed + i];
    give_back(s->arena, mark);
    return wrong;
}

int add_contact_jump(struct system *s, const double *q, int speed, const double *wanted, double *du)
{
    const int rows = active_rows(s, speed);
    const struct mark mark = s->arena->top;
    struct problem p;
    int wrong = take_problem(s, rows, &p);
    if (!wrong) {
        memcpy(p.wanted, wanted, rows * sizeof *wanted);
        less_rates(s, q, rows, du, &p);
        wrong = push(s, q, rows, 0, &p, du);
    }
    give_back(s->arena, mark);
    return wrong;
}
