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
#include "constraints/contact_forces.h"

#include <string.h>

#include "algebra/elimination.h"
#include "algebra/semidefinite.h"
#include "base/tolerances.h"

/* x <- W^-1 x; 1 where W is nearly singular, 2 where its determinant is negative: friction then pushes harder the more it is
 * resisted, and a contact however stiff would not stay as it is. */
static int solve_sliding(int n, double *W, double *x)
{
    const int sign = eliminate(n, W, x, CONTACT_PIVOT);
    return sign > 0 ? 0 : sign < 0 ? 2 : 1;
}

/* Forces (impulses) whose columns bring the rates by wanted[rows] further, added to motion[n]; nonzero where they, or the
 * closure, are nearly dependent, or friction jams. */
static int push(struct system *s, const double *q, int rows, int friction, double *force, double *motion)
{
    struct active_set *h = s->active;
    const struct ccgen_model *m = s->model;
    const int width = width_of(s), c = m->contacts;
    int sliding = 0;
    for (int j = 0; j < rows; j++) {
        const int i = h->of[j], contact = h->set[i], slides = friction ? against(h->mode[i]) : 0;
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
    const int wrong =
        sliding ? solve_sliding(rows, h->W, h->wanted) : solve_definite_well(rows, h->W, h->wanted, h->solved);
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
    struct active_set *h = s->active;
    s->model->gap_rates(s->k, q, motion, h->rates);
    if (rows > h->count)
        s->model->slips(s->k, q, motion, h->slips);
    for (int i = 0; i < rows; i++)
        h->wanted[i] -= (i < h->count ? h->rates : h->slips)[h->set[h->of[i]]];
}

int add_contact_accelerations(struct system *s, const double *q, const double *u, double *u_dot)
{
    struct active_set *h = s->active;
    active_bias(s, q, u, h->wanted);
    for (int i = 0; i < h->rows; i++)
        h->wanted[i] = -h->wanted[i];
    less_rates(s, q, h->rows, u_dot);
    return push(s, q, h->rows, 1, h->force, u_dot);
}

int add_contact_jump(struct system *s, const double *q, int speed, const double *wanted, double *du)
{
    struct active_set *h = s->active;
    const int rows = active_rows(s, speed);
    memmove(h->wanted, wanted, rows * sizeof *wanted);
    less_rates(s, q, rows, du);
    return push(s, q, rows, 0, h->force, du);
}
