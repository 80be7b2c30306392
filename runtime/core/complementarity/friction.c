/* Coulomb friction at contacts in the plane as one complementarity problem.
 *
 * With r = mu Pn + Pt and l = mu Pn - Pt, the two distances of a tangential impulse from its limits, and the sliding split
 * into its forward and backward part, vt = vr - vl,
 *
 *     vn = Gnn Pn + Gnt Pt + bn,   vt = Gtn Pn + Gtt Pt + bt,   l = 2 mu Pn - r,
 *     0 <= (Pn, r, vl)  complementary to  (vn, vr, l) >= 0 ,
 *
 * which is linear in (Pn, r, vl) (F. Pfeiffer, C. Glocker, Multibody Dynamics with Unilateral Contacts, 1996, section 8).
 * A contact known to slide needs its normal row alone, with Pt = -mu Pn forward. It is solved by pivoting; where that ends on
 * a ray there is no solution: friction jams (Painleve). That holds in exact arithmetic. So every answer is put back into
 * Coulomb's law, and where it does not meet it, or there is none, others are looked for: by other pivots, contact by contact,
 * and where contacts are few by trying every way in which they can push, stick, slide and leave.
 */
#include "complementarity/friction.h"

#include <math.h>
#include <string.h>

#include "base/tolerances.h"
#include "complementarity/coulomb.h"
#include "complementarity/least_impulses.h"
#include "complementarity/ways.h"
#include "complementarity/lemke.h"

enum { SWEEPS = 20000, THOUSAND = 1000, RESTARTS = 12, SHIFTS = 3 };
/* times the largest rate: breaks ties */
static const double SHIFT[SHIFTS] = {CCGEN_LIMIT(1e-10, 1e-4), CCGEN_LIMIT(1e-7, 1e-3), CCGEN_LIMIT(1e-12, 1e-5)};

/* Times what ends the approach of each contact alone and smooth, or the least impulses: more is looked at twice */
static const double LARGE = 2.0;

/* Times that: what the law is kept to (CONSISTENT) is then more than a ten-millionth of what approaches */
static const double WEDGED = 1e3;

/* Part of the largest impulse: what changes by less in all passes is not waited for */
static const double SLIGHT = 1e-2;

static double row_rate(const struct friction_problem *c, int row, const double *Pn, const double *Pt)
{
    const int n = c->n;
    double rate = row < n ? c->bn[row] : c->bt[row - n];
    for (int j = 0; j < n; j++)
        rate += c->W[(size_t)row * 2 * n + j] * Pn[j] + c->W[(size_t)row * 2 * n + n + j] * Pt[j];
    return rate;
}

/* Contact by contact, again and again, for more contacts than there are ways to try: 0 where the impulses are finite. They have settled, or do not by
 * the end: what a thousand passes do not halve, and all of them move by no more than a hundredth, is left as it is. */
static int sweep(const struct friction_problem *c, double *Pn, double *Pt)
{
    const int n = c->n;
    memset(Pn, 0, n * sizeof *Pn);
    memset(Pt, 0, n * sizeof *Pt);
    double before = INFINITY; /* the change a thousand passes ago, of the largest impulse */
    for (int pass = 1; pass <= SWEEPS; pass++) {
        double change = 0.0, largest = 0.0;
        for (int i = 0; i < n; i++) {
            const double *normal = c->W + (size_t)i * 2 * n, *tangent = normal + (size_t)n * 2 * n;
            const int slides = c->slides[i];
            const double own = normal[i] - slides * c->mu[i] * normal[n + i], was = Pn[i], pulled = Pt[i];
            if (!(own > 0.0))
                return 1;
            Pn[i] = fmax(c->least ? c->least[i] : 0.0, was - row_rate(c, i, Pn, Pt) / own);
            const double limit = c->rough[i] ? c->mu[i] * Pn[i] : 0.0;
            Pt[i] = slides ? -slides * limit : fmin(fmax(pulled, -limit), limit);
            if (!slides && limit > 0.0)
                Pt[i] = fmin(fmax(Pt[i] - row_rate(c, n + i, Pn, Pt) / tangent[n + i], -limit), limit);
            change = fmax(change, fmax(fabs(Pn[i] - was), fabs(Pt[i] - pulled)));
            largest = fmax(largest, Pn[i]);
        }
        if (!isfinite(largest))
            return 1;
        if (change <= SWEPT * largest)
            return 0;
        if (pass % THOUSAND == 0) {
            if (change > 0.5 * before * largest && change * SWEEPS <= SLIGHT * largest)
                return 0;
            before = change / largest;
        }
    }
    return 0;
}

/* The complementarity problem of the contacts in the unknowns of the head of this file. */
struct pivots {
    int m;
    int *place;                               /* [n] where r of a contact stands, vl behind it; -1 where it has none */
    double *k;                                /* [n] Pt = -k Pn + r */
    double *M, *q, *cover, *shift, *z, *unit; /* [m][m], [m] and so on; unit: of a row, the root of its compliance */
    char *in;                                 /* [m] of the basis */
    signed char *limit;                       /* [n] at which friction is, as in impulses_of */
    double *best, worst;                      /* [2n] the answer that breaks the law least, and by how much */
};

static void assemble(const struct friction_problem *c, struct pivots *p)
{
    const int n = c->n, m = p->m;
    for (int i = 0; i < n; i++)
        for (int t = 0; t < (p->place[i] < 0 ? 1 : 2); t++) {
            const double *row = c->W + (size_t)(i + t * n) * 2 * n, own = sqrt(fmax(row[i + t * n], 0.0));
            const int r = t ? p->place[i] : i;
            p->q[r] = t ? c->bt[i] : c->bn[i];
            p->unit[r] = own > 0.0 ? own : 1.0;
            for (int j = 0; j < n; j++) {
                p->M[r * m + j] = row[j] - row[n + j] * p->k[j];
                if (c->least)
                    p->q[r] += p->M[r * m + j] * c->least[j];
                if (p->place[j] >= 0)
                    p->M[r * m + p->place[j]] = row[n + j];
            }
            if (t) {
                p->M[r * m + r + 1] = 1.0;
                p->M[(r + 1) * m + i] = 2.0 * c->mu[i];
                p->M[(r + 1) * m + r] = -1.0;
                p->q[r + 1] = c->least ? 2.0 * c->mu[i] * c->least[i] : 0.0;
                p->unit[r + 1] = 1.0 / p->unit[r];
            }
        }
}

/* A cover and a shift of their own for every restart, in no order that could be that of the problem */
static void vary(struct pivots *p, int restart)
{
    double speed = 0.0;
    for (int i = 0; i < p->m; i++)
        speed = fmax(speed, fabs(p->q[i]) / p->unit[i]);
    for (int i = 0; i < p->m; i++) {
        const double place = 0.6180339887498949 * (restart * p->m + i), part = place - (double)(long)place;
        p->cover[i] = p->unit[i] * (1.0 + part);
        p->shift[i] = SHIFT[restart % SHIFTS] * speed * p->unit[i] * (2.0 - part);
    }
}

/* Whether an answer meets the law; if none does, the best one is remembered: that which breaks the law least, or where the law may be missed, misses it least. */
static int meets(const struct friction_problem *c, struct pivots *p, const double *Pn, const double *Pt)
{
    const double worst = coulomb_residual(c, Pn, Pt), misses = c->missed > 0.0 ? coulomb_miss(c, Pn, Pt) : worst;
    if (misses < p->worst) {
        p->worst = misses;
        memcpy(p->best, Pn, c->n * sizeof *Pn);
        memcpy(p->best + c->n, Pt, c->n * sizeof *Pt);
    }
    return worst <= CONSISTENT;
}

/* By pivots, and where those have lost too many digits, once more from which contacts they let push, slide and stick: 0 where
 * the law is met. */
static int pivots(const struct friction_problem *c, struct pivots *p, int restart, double *Pn, double *Pt)
{
    if (restart)
        vary(p, restart);
    const int wrong =
        lemke(c->arena, p->m, p->M, p->q, restart ? p->cover : NULL, restart ? p->shift : NULL, p->z, p->in);
    if (wrong)
        return wrong;
    for (int i = 0; i < c->n; i++) {
        const int r = p->place[i];
        Pn[i] = p->z[i] + (c->least ? c->least[i] : 0.0);
        Pt[i] = r < 0 ? -p->k[i] * Pn[i] : p->z[r] - c->mu[i] * Pn[i];
        p->limit[i] = r < 0 || !p->in[r] ? -1 : p->in[r + 1];
    }
    if (meets(c, p, Pn, Pt))
        return 0;
    return impulses_of(c, p->in, p->limit, Pn, Pt) || !meets(c, p, Pn, Pt) ? 3 : 0;
}

static int search(const struct friction_problem *c, struct pivots *p, double *Pn, double *Pt)
{
    const int first = pivots(c, p, 0, Pn, Pt);
    if (!first)
        return 0;
    for (int restart = 1; restart <= RESTARTS; restart++)
        if (!pivots(c, p, restart, Pn, Pt))
            return 0;
    if (!least_impulses(c, NOTHING, Pn, Pt) || (!sweep(c, Pn, Pt) && meets(c, p, Pn, Pt)))
        return 0;
    if (p->worst > (c->missed > 0.0 ? c->missed : NEARLY_CONSISTENT))
        return first == 2 ? 2 : 1;
    memcpy(Pn, p->best, c->n * sizeof *Pn);
    memcpy(Pt, p->best + c->n, c->n * sizeof *Pt);
    return 0;
}

/* Where the unknowns of every contact stand: p->place, p->k and p->m */
static void place_unknowns(const struct friction_problem *c, struct pivots *p)
{
    p->m = c->n;
    for (int i = 0; i < c->n; i++) {
        const int slides = c->slides[i], unknown = c->rough[i] && !slides;
        p->place[i] = unknown ? p->m : -1;
        p->m += unknown ? 2 : 0;
        p->k[i] = slides ? slides * c->mu[i] : unknown ? c->mu[i] : 0.0;
    }
}

int solve_friction(const struct friction_problem *c, double *Pn, double *Pt)
{
    struct arena *arena = c->arena;
    const struct mark mark = arena->top;
    const size_t n = c->n;
    struct pivots p = {.worst = INFINITY, .place = TAKE(arena, int, n), .k = TAKE(arena, double, n)};
    int result = 2;
    if (arena->ran_out)
        goto end;
    place_unknowns(c, &p);
    const size_t m = p.m;
    p.M = TAKE_ZEROS(arena, double, (m * m));
    p.q = TAKE(arena, double, m);
    p.cover = TAKE(arena, double, m);
    p.shift = TAKE(arena, double, m);
    p.z = TAKE(arena, double, m);
    p.unit = TAKE(arena, double, m);
    p.best = TAKE(arena, double, 2 * n);
    p.in = TAKE(arena, char, m);
    p.limit = TAKE(arena, signed char, n);
    if (arena->ran_out)
        goto end;
    assemble(c, &p);
    result = search(c, &p, Pn, Pt);
end:
    give_back(arena, mark);
    return result;
}

/* Take, in place of impulses that wedge contacts, those that sweeps come to from none, if they miss the law by less: contacts that press each other
 * with what moves nothing may do so with any impulse, and pivots go as far as they happen to. */
static void loosen(const struct friction_problem *c, double *Pn, double *Pt)
{
    const size_t n = c->n;
    const struct mark mark = c->arena->top;
    double *normal = TAKE(c->arena, double, n), *tangent = TAKE(c->arena, double, n);
    if (!c->arena->ran_out && !sweep(c, normal, tangent) &&
        coulomb_miss(c, normal, tangent) < coulomb_miss(c, Pn, Pt)) {
        memcpy(Pn, normal, n * sizeof *Pn);
        memcpy(Pt, tangent, n * sizeof *Pt);
    }
    give_back(c->arena, mark);
}

int solve_friction_least(const struct friction_problem *c, double *Pn, double *Pt)
{
    const int wrong = solve_friction(c, Pn, Pt);
    if (wrong)
        return wrong;
    const double usual = LARGE * caused(c);
    const int large = loaded(c, Pn) > usual;
    if ((large || c->n == 1 || !c->least || loaded(c, c->least) == 0.0) &&
        least_impulses(c, large ? IMPULSES : MOTION, Pn, Pt) && loaded(c, Pn) > WEDGED * usual)
        loosen(c, Pn, Pt);
    refine_impulses(c, Pn, Pt);
    return 0;
}
