/* Expansion at several contacts, followed along the impulses; see expansion.h.
 *
 * All contacts that have work to give back, or by Poisson's law impulses, push in fixed proportions, p_i = x w_i, with the friction of their present sliding, or
 * what sticking needs; the others as much as keeps them from approaching. That is piecewise linear in x: the forces of a piece,
 * impulses per x, are those of a problem of friction among what is closed or pushes; it ends where a contact has given back
 * what it has, sliding ends, or a gap stops opening. No force of a piece does work but for those that give back, and
 * friction only takes: with no more to give back than what was lost, energy is never gained, wherever expansion ends. So it
 * ends where no work is given back any more, as in a wedge, or too little: see MOST.
 */
#include "impact/expansion.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "base/tolerances.h"
#include "complementarity/complementarity.h"
#include "complementarity/friction.h"
#include "impact/problem.h"

enum { PIECES = 32 };                           /* per contact */
static const double FAR = 16.0, FARTHEST = 1e9; /* times what the largest push does to its own row */
/* Where friction leaves the share c of what normal impulses push, to give back e^2 of the work takes e c^(-1/2) times the impulse
 * of compression: without bound near a wedge, where c = 0 and nothing comes back. Expansion ends after MOST times the impulses of
 * compression: the speed that is left out then, e^2 (r - MOST r^2) u for r = c^(1/2) / e < 1 / MOST, is below e^2 u / (4 MOST). */
const double MOST = 3.0;

/* One piece: what its forces are to do, and what they are, impulses and rates per x */
struct piece {
    double *least; /* [n] with which a contact pushes in any case */
    double *b;     /* [2 n] scratch */
    double *P, *F; /* [n] */
    double *rate;  /* [2 n] */
    double *left;  /* [n] work, or impulse, that is still to be given back */
    signed char *mode;
    char *gives; /* [n] still gives back */
};

/* 0, or 1 when memory runs out */
static int take_piece(struct arena *arena, struct piece *p, size_t n)
{
    p->least = TAKE(arena, double, n);
    p->b = TAKE(arena, double, 2 * n);
    p->P = TAKE_ZEROS(arena, double, n);
    p->F = TAKE_ZEROS(arena, double, n);
    p->rate = TAKE_ZEROS(arena, double, 2 * n);
    p->left = TAKE(arena, double, n);
    p->mode = TAKE(arena, signed char, n);
    p->gives = TAKE(arena, char, n);
    return arena->ran_out;
}

static double root(const struct expansion *s, int i)
{
    return sqrt(fmax(s->W[(size_t)i * (s->all + 1)], 0.0));
}

/* Rates per x. What is closed, or sticks, stays so where only rounding says otherwise. */
static void rates_of(const struct expansion *s, struct piece *p)
{
    for (int i = 0; i < s->all; i++) {
        double rate = 0.0, size = 0.0;
        for (int j = 0; j < s->all; j++) {
            const double term = s->W[(size_t)i * s->all + j] * (j < s->n ? p->P[j] : p->F[j - s->n]);
            rate += term;
            size += fabs(term);
        }
        p->rate[i] = s->rate[i] == 0.0 && fabs(rate) <= CONSISTENT * size ? 0.0 : rate;
    }
}

/* Impulses per x from p->b and p->least; nonzero where there are none */
static int solve_forces(const struct expansion *s, struct piece *p)
{
    const int n = s->n;
    if (s->all > n) {
        struct friction_problem rough = {.n = n,
                                         .W = s->W,
                                         .bn = p->b,
                                         .bt = p->b + n,
                                         .mu = s->mu,
                                         .mode = p->mode,
                                         .least = p->least,
                                         .arena = s->arena};
        const struct mark mark = s->arena->top;
        const int wrong = prepare_friction(&rough) ? 2 : solve_friction_least(&rough, p->P, p->F);
        give_back(s->arena, mark);
        return wrong;
    }
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            p->b[i] += s->W[(size_t)i * n + j] * p->least[j];
    const int wrong = solve_complementarity(s->arena, n, s->W, p->b, p->P);
    for (int i = 0; i < n && !wrong; i++)
        p->P[i] += p->least[i];
    return wrong;
}

/* The forces of a piece. What is opening pushes with its least alone: its row is offset so far that no force of the piece closes
 * it. Nonzero where there are none. */
static int solve_piece(const struct expansion *s, struct piece *p)
{
    const int n = s->n;
    double largest = 0.0;
    memset(p->F, 0, n * sizeof *p->F);
    for (int i = 0; i < n; i++) {
        const double slides = s->all == n ? 0.0 : s->rate[n + i];
        p->mode[i] = (signed char)((slides > 0.0) - (slides < 0.0));
        largest = fmax(largest, root(s, i) * p->least[i]);
    }
    for (double far = FAR; far <= FARTHEST; far *= FAR) {
        int closes = 0;
        memset(p->b, 0, 2 * n * sizeof *p->b);
        for (int i = 0; i < n; i++)
            p->b[i] = s->rate[i] > 0.0 ? far * largest * root(s, i) : 0.0;
        const int wrong = solve_forces(s, p);
        if (wrong)
            return wrong;
        for (int i = 0; i < n; i++)
            closes |= s->rate[i] > 0.0 && root(s, i) * (p->P[i] - p->least[i]) > RATE_ROUNDING * largest;
        if (!closes) {
            rates_of(s, p);
            return 0;
        }
    }
    return 1;
}

/* Where a value that has a sign comes to zero */
static double until_zero(double value, double change)
{
    return value * change < 0.0 ? -value / change : INFINITY;
}

/* Until contact i has given back what it has */
static double until_given(const struct expansion *s, const struct piece *p, int i)
{
    const double left = p->left[i] / p->P[i];
    return s->goal ? until_work(s->rate[i], p->rate[i], left) : left;
}

/* How far a piece goes that may load the contacts by `most`; 0 where it gives nothing back */
static double length_of(const struct expansion *s, const struct piece *p, double most)
{
    double longest = most / load_of(s->n, s->all, s->W, p->P);
    int back = 0;
    for (int i = 0; i < s->all; i++)
        longest = fmin(longest, until_zero(s->rate[i], p->rate[i]));
    for (int i = 0; i < s->n; i++)
        if (p->gives[i]) {
            back |= !s->goal || s->rate[i] > 0.0 || p->rate[i] > 0.0;
            longest = fmin(longest, until_given(s, p, i));
        }
    return back ? longest : 0.0;
}

/* Go on by dx: what ends then, or so soon after it that rounding decides, is at its end. Whether any has work left to give back */
static int advance_expansion(struct expansion *s, struct piece *p, double dx)
{
    const double end = dx * (1.0 + RATE_ROUNDING);
    int giving = 0;
    for (int i = 0; i < s->n; i++) {
        const int done = p->gives[i] && until_given(s, p, i) <= end;
        p->left[i] -= p->gives[i] ? p->P[i] * (s->goal ? s->rate[i] + 0.5 * p->rate[i] * dx : 1.0) * dx : 0.0;
        p->gives[i] = p->gives[i] && !done && p->left[i] > 0.0;
        giving |= p->gives[i];
        s->P[i] += p->P[i] * dx;
        s->F[i] += p->F[i] * dx;
    }
    for (int i = 0; i < s->all; i++)
        s->rate[i] = until_zero(s->rate[i], p->rate[i]) <= end ? 0.0 : s->rate[i] + p->rate[i] * dx;
    return giving;
}

int expand(struct expansion *s)
{
    struct piece p;
    const struct mark mark = s->arena->top;
    const int n = s->n, wrong = take_piece(s->arena, &p, n);
    double most = MOST * load_of(n, s->all, s->W, s->P);
    int giving = 0;
    for (int i = 0; i < n && !wrong; i++) {
        p.left[i] = s->goal ? s->goal[i] : s->wanted[i];
        p.gives[i] = s->wanted[i] > 0.0 && p.left[i] > 0.0;
        giving |= p.gives[i];
    }
    for (int piece = 0; giving && most > 0.0 && piece < PIECES * n; piece++) {
        for (int i = 0; i < n; i++)
            p.least[i] = p.gives[i] ? s->wanted[i] : 0.0;
        const double dx = solve_piece(s, &p) ? 0.0 : length_of(s, &p, most);
        if (!(dx > 0.0))
            break;
        giving = advance_expansion(s, &p, dx);
        most -= load_of(n, s->all, s->W, p.P) * dx;
    }
    give_back(s->arena, mark);
    return wrong;
}
