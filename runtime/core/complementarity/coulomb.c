/* Coulomb's law at rough contacts: what must hold of impulses.
 *
 * At a contact, either the impulse is above its least or the gap opens; friction is within the limits mu Pn, and at the one
 * against the sliding where it slides. What is rounding is told by the sizes of the terms of each row, and by those of all
 * rows, which one solution for all of them mixes; units cancel with the square roots of the diagonal of W.
 */
#include "complementarity/coulomb.h"

#include <math.h>

#include "base/tolerances.h"

/* Whether no impulse moves contact i along its ground. */
static int constrained_tangentially(const struct friction_problem *c, int i)
{
    const double *tangent = c->W + (size_t)(c->n + i) * 2 * c->n;
    const double own = c->W[(size_t)i * (2 * c->n + 1)];
    return tangent[c->n + i] <= DBL_EPSILON * own && fabs(tangent[i]) <= RATE_ROUNDING * own;
}

int prepare_friction(struct friction_problem *c)
{
    const int n = c->n;
    c->root = TAKE(c->arena, double, 2 * (size_t)n);
    c->slides = TAKE(c->arena, signed char, n);
    c->rough = TAKE(c->arena, char, n);
    c->against = TAKE(c->arena, double, n);
    if (c->arena->ran_out)
        return 1;
    for (int row = 0; row < 2 * n; row++)
        c->root[row] = sqrt(fmax(c->W[(size_t)row * (2 * n + 1)], 0.0));
    for (int i = 0; i < n; i++) {
        const int fixed = constrained_tangentially(c, i);
        if (fixed) /* what stands there is rounding, by which nothing can be divided */
            c->root[n + i] = 0.0;
        c->slides[i] = c->mode[i];
        if (!c->mode[i] && fixed && fabs(c->bt[i]) > RATE_ROUNDING * fabs(c->bn[i]))
            c->slides[i] = c->bt[i] > 0.0 ? 1 : -1;
        c->rough[i] = c->mu[i] > 0.0 && (c->slides[i] || !fixed);
        const int forward = c->slides[i] ? c->slides[i] > 0 : c->bt[i] >= 0.0;
        c->against[i] = !c->rough[i] ? 0.0 : forward ? -c->mu[i] : c->mu[i];
    }
    return 0;
}

double rate_of(const struct friction_problem *c, int row, const double *Pn, const double *Pt, double *size)
{
    const int n = c->n;
    double rate = row < n ? c->bn[row] : c->bt[row - n];
    *size = fabs(rate);
    for (int j = 0; j < 2 * n; j++) {
        const double term = c->W[(size_t)row * 2 * n + j] * (j < n ? Pn[j] : Pt[j - n]);
        rate += term;
        *size += fabs(term);
    }
    return rate;
}

struct sizes sizes_of(const struct friction_problem *c, const double *Pn, const double *Pt)
{
    struct sizes of = {0.0, 0.0, 0.0};
    for (int i = 0; i < 2 * c->n; i++) {
        const double root_W = c->root[i], b = i < c->n ? c->bn[i] : c->bt[i - c->n];
        const double least = c->least && i < c->n ? root_W * c->least[i] : 0.0;
        of.load = fmax(of.load, fmax(least, root_W * fabs(i < c->n ? Pn[i] : Pt[i - c->n])));
        of.cause = fmax(of.cause, fmax(least, root_W > 0.0 ? fabs(b) / root_W : 0.0));
    }
    of.speed = fmax(of.cause, of.load);
    return of;
}

/* Whether impulses are so large that their rounding drowns what they come from: pivots near a ray lead there. */
static int drowned(const struct sizes *of)
{
    return of->load * DBL_EPSILON > DROWNED * of->cause;
}

double scaled_rate(const struct friction_problem *c, int row, const double *Pn, const double *Pt,
                   const struct sizes *of)
{
    double terms;
    const double rate = rate_of(c, row, Pn, Pt, &terms), root = c->root[row];
    double size = terms + MIXED * of->speed * root;
    if (size > FAR_LARGER * of->cause * root && root > 0.0)
        size = fmax(FAR_LARGER * of->cause * root, TERM_ROUNDING / CONSISTENT * size);
    return size > 0.0 ? rate / size : 0.0;
}

/* As `coulomb_residual`, of the friction at contact i that slides with the scaled rate vt */
static double friction_broken(const struct friction_problem *c, int i, double Pn, double Pt, double vt, double load)
{
    const double root_W = c->root[c->n + i], limit = c->mu[i] * Pn;
    const double size = root_W * limit + MIXED * load;
    if (!(size > 0.0) || !c->rough[i])
        return 0.0;
    if (c->slides[i])
        return root_W * fabs(Pt + c->slides[i] * limit) / size;
    const double beyond = root_W * (fabs(Pt) - limit) / size;
    const double within = root_W * (limit + copysign(Pt, vt * Pt)) / size;
    return fmax(beyond, fmin(fabs(vt), within));
}

double coulomb_residual(const struct friction_problem *c, const double *Pn, const double *Pt)
{
    double worst = 0.0;
    const struct sizes of = sizes_of(c, Pn, Pt);
    const double load = of.load;
    if (drowned(&of))
        return INFINITY;
    for (int i = 0; i < c->n; i++) {
        const double extra = Pn[i] - (c->least ? c->least[i] : 0.0);
        const double push = load > 0.0 ? c->root[i] * extra / load : 0.0, vn = scaled_rate(c, i, Pn, Pt, &of);
        const double vt = scaled_rate(c, c->n + i, Pn, Pt, &of);
        worst = fmax(worst, fmax(fmax(-vn, -push), fmin(vn, push)));
        worst = fmax(worst, friction_broken(c, i, Pn[i], Pt[i], vt, load));
        if (!isfinite(Pn[i]) || !isfinite(Pt[i]))
            return INFINITY;
    }
    return worst;
}

double coulomb_miss(const struct friction_problem *c, const double *Pn, const double *Pt)
{
    double worst = 0.0, size;
    for (int i = 0; i < c->n; i++) {
        const double normal = c->root[i], tangent = c->root[c->n + i];
        const double push = normal * (Pn[i] - (c->least ? c->least[i] : 0.0));
        const double vn = normal > 0.0 ? rate_of(c, i, Pn, Pt, &size) / normal : 0.0;
        worst = fmax(worst, fmax(fmax(-vn, -push), fmin(vn, push)));
        if (!isfinite(Pn[i]) || !isfinite(Pt[i]))
            return INFINITY;
        if (!c->rough[i] || !(tangent > 0.0))
            continue;
        const double vt = rate_of(c, c->n + i, Pn, Pt, &size) / tangent;
        const double limit = tangent * c->mu[i] * Pn[i], held = tangent * Pt[i];
        const double lacks = limit + copysign(held, vt * held);
        worst = fmax(worst, c->slides[i] ? fabs(held + c->slides[i] * limit)
                                         : fmax(fabs(held) - limit, fmin(fabs(vt), lacks)));
    }
    return worst > 0.0 ? worst / caused(c) : 0.0;
}

void rates_after(const struct friction_problem *c, const double *Pn, const double *Pt, double *rates)
{
    const struct sizes of = sizes_of(c, Pn, Pt);
    double size;
    for (int row = 0; row < 2 * c->n; row++)
        rates[row] = fabs(scaled_rate(c, row, Pn, Pt, &of)) <= CONSISTENT ? 0.0 : rate_of(c, row, Pn, Pt, &size);
}

double loaded(const struct friction_problem *c, const double *Pn)
{
    double sum = 0.0;
    for (int i = 0; i < c->n; i++)
        sum += c->root[i] * Pn[i];
    return sum;
}

double approaching(const struct friction_problem *c)
{
    double sum = 0.0;
    for (int i = 0; i < c->n; i++)
        sum += c->root[i] > 0.0 ? fmax(0.0, -c->bn[i]) / c->root[i] : 0.0;
    return sum;
}

double caused(const struct friction_problem *c)
{
    return approaching(c) + (c->least ? loaded(c, c->least) : 0.0);
}
