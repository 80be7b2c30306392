/* Coulomb's law at rough contacts: what must hold of impulses, and all ways in which it can.
 *
 * At a contact, either the impulse is above its least or the gap opens; friction is within the limits mu Pn, and at the one
 * against the sliding where it slides. What is rounding is told by the sizes of the terms of each row, and by those of all
 * rows, which one solution for all of them mixes; units cancel with the square roots of the diagonal of W.
 *
 * A way says of every contact whether it pushes or keeps its least impulse, and whether its friction is at one limit, at the
 * other, or holds it. Its impulses follow from one linear system. Ways whose systems are singular are left out: where impulses
 * are not unique, those without superfluous ones remain, as the corners of a linear program. Of consistent ways that of least
 * normal impulses is taken: at a mechanism of one freedom, where sliding and approach end together and any larger impulse
 * could be held by friction, it is where the process of the impact ends.
 */
#include "complementarity/coulomb.h"

#include <math.h>
#include <string.h>

#include "algebra/elimination.h"
#include "base/tolerances.h"

enum { MOST = 50000, REFINEMENTS = 3 }; /* ways: at six contacts all, also in expansion */

/* What a contact may do, in the order in which ways of equal impulses are preferred: it pushes or keeps its least impulse, and
 * its friction is against the sliding that it had (forward where it had none), holds it, or is the other way. */
enum { ON, HELD_FAST, BACK, LEAST_ON, LEAST_HELD, LEAST_BACK, KINDS };

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
        c->slides[i] = c->mode[i];
        if (!c->mode[i] && fixed && fabs(c->bt[i]) > RATE_ROUNDING * fabs(c->bn[i]))
            c->slides[i] = c->bt[i] > 0.0 ? 1 : -1;
        c->rough[i] = c->mu[i] > 0.0 && (c->slides[i] || !fixed);
        const int forward = c->slides[i] ? c->slides[i] > 0 : c->bt[i] >= 0.0;
        c->against[i] = !c->rough[i] ? 0.0 : forward ? -c->mu[i] : c->mu[i];
    }
    return 0;
}

/* Rate of a row, normals then tangents, and the size of its terms */
static double rate_of(const struct friction_problem *c, int row, const double *Pn, const double *Pt, double *size)
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

/* Whether impulses are so large that their rounding drowns what they come from: pivots near a ray lead there. */
static int drowned(const struct friction_problem *c, const double *Pn, const double *Pt)
{
    double load = 0.0, cause = 0.0;
    for (int i = 0; i < 2 * c->n; i++) {
        const double root_W = c->root[i], b = i < c->n ? c->bn[i] : c->bt[i - c->n];
        load = fmax(load, root_W * fabs(i < c->n ? Pn[i] : Pt[i - c->n]));
        cause = fmax(cause, c->least && i < c->n ? root_W * c->least[i] : 0.0);
        cause = fmax(cause, root_W > 0.0 ? fabs(b) / root_W : 0.0);
    }
    return load * DBL_EPSILON > DROWNED * cause;
}

/* The largest impulse as it loads its contact, and the largest speed, both in units of the root of an energy */
static void sizes(const struct friction_problem *c, const double *Pn, const double *Pt, double *load, double *speed)
{
    *load = *speed = 0.0;
    for (int i = 0; i < 2 * c->n; i++) {
        const double root_W = c->root[i], b = i < c->n ? c->bn[i] : c->bt[i - c->n];
        *load = fmax(*load, root_W * fabs(i < c->n ? Pn[i] : Pt[i - c->n]));
        *load = fmax(*load, c->least && i < c->n ? root_W * c->least[i] : 0.0);
        if (root_W > 0.0)
            *speed = fmax(*speed, fabs(b) / root_W);
    }
    *speed = fmax(*speed, *load);
}

/* Rate of a row in parts of what its rounding is in parts of */
static double scaled_rate(const struct friction_problem *c, int row, const double *Pn, const double *Pt, double speed)
{
    double size;
    const double rate = rate_of(c, row, Pn, Pt, &size);
    size += MIXED * speed * c->root[row];
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
    double worst = 0.0, load, speed;
    if (drowned(c, Pn, Pt))
        return INFINITY;
    sizes(c, Pn, Pt, &load, &speed);
    for (int i = 0; i < c->n; i++) {
        const double extra = Pn[i] - (c->least ? c->least[i] : 0.0);
        const double push = load > 0.0 ? c->root[i] * extra / load : 0.0, vn = scaled_rate(c, i, Pn, Pt, speed);
        const double vt = scaled_rate(c, c->n + i, Pn, Pt, speed);
        worst = fmax(worst, fmax(fmax(-vn, -push), fmin(vn, push)));
        worst = fmax(worst, friction_broken(c, i, Pn[i], Pt[i], vt, load));
        if (!isfinite(Pn[i]) || !isfinite(Pt[i]))
            return INFINITY;
    }
    return worst;
}

void rates_after(const struct friction_problem *c, const double *Pn, const double *Pt, double *rates)
{
    double load, speed, size;
    sizes(c, Pn, Pt, &load, &speed);
    for (int row = 0; row < 2 * c->n; row++)
        rates[row] = fabs(scaled_rate(c, row, Pn, Pt, speed)) <= CONSISTENT ? 0.0 : rate_of(c, row, Pn, Pt, &size);
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

/* Friction per normal impulse of contact i whose friction is at a limit */
static double at_limit(const struct friction_problem *c, int i, int kind)
{
    return c->slides[i] || kind == ON || kind == LEAST_ON ? c->against[i] : -c->against[i];
}

static int holds_fast(int kind)
{
    return kind == HELD_FAST || kind == LEAST_HELD;
}

/* The unknown impulses of a way, normals and then tangents, as column[m]; returns m. */
static int unknowns_of_way(const struct friction_problem *c, const signed char *way, int *column)
{
    int m = 0;
    for (int i = 0; i < c->n; i++)
        if (way[i] < LEAST_ON)
            column[m++] = i;
    for (int i = 0; i < c->n; i++)
        if (holds_fast(way[i]))
            column[m++] = c->n + i;
    return m;
}

/* Rows of the linear system of a way: by what its unknowns have to change so that the rates of row[rows] become zero from what
 * they are with Pn and Pt, or without any (NULL). A[rows][m], x[rows]. */
static void rows_of_way(const struct friction_problem *c, const signed char *way, int m, const int *column, int rows,
                        const int *row, const double *Pn, const double *Pt, double *A, double *x)
{
    const int n = c->n;
    for (int i = 0; i < rows; i++) {
        const double *own = c->W + (size_t)row[i] * 2 * n;
        double size;
        x[i] = Pn ? -rate_of(c, row[i], Pn, Pt, &size) : row[i] < n ? -c->bn[row[i]] : -c->bt[row[i] - n];
        for (int j = 0; j < m; j++) {
            const int k = column[j], slides = k < n && !holds_fast(way[k]);
            A[i * m + j] = own[k] + (slides ? at_limit(c, k, way[k]) * own[n + k] : 0.0);
        }
    }
}

/* Impulse number k, normals and then tangents, changes by `by`, and friction at its limit with it. */
static void change(const struct friction_problem *c, const signed char *way, int k, double by, double *Pn, double *Pt)
{
    if (k >= c->n) {
        Pt[k - c->n] += by;
        return;
    }
    Pn[k] += by;
    if (!holds_fast(way[k]))
        Pt[k] = at_limit(c, k, way[k]) * Pn[k];
}

/* Impulses of one way; 1 where they are not unique. A[2n][2n], x[2n] and column[2n] are scratch. */
static int of_way(const struct friction_problem *c, const signed char *way, double *A, double *x, int *column,
                  double *Pn, double *Pt)
{
    for (int i = 0; i < c->n; i++) {
        Pn[i] = way[i] < LEAST_ON || !c->least ? 0.0 : c->least[i];
        Pt[i] = holds_fast(way[i]) ? 0.0 : at_limit(c, i, way[i]) * Pn[i];
    }
    const int m = unknowns_of_way(c, way, column);
    rows_of_way(c, way, m, column, m, column, c->least ? Pn : NULL, Pt, A, x);
    if (m && !eliminate(m, A, x, SINGULAR_MODES))
        return 1;
    for (int j = 0; j < m; j++)
        change(c, way, column[j], x[j], Pn, Pt);
    return 0;
}

int impulses_of(const struct friction_problem *c, const char *push, const signed char *limit, double *Pn, double *Pt)
{
    const size_t n = c->n;
    const struct mark mark = c->arena->top;
    double *A = TAKE(c->arena, double, 4 * n * n), *x = TAKE(c->arena, double, 2 * n);
    int *column = TAKE(c->arena, int, 2 * n), wrong = 1;
    signed char *way = TAKE(c->arena, signed char, n);
    if (!c->arena->ran_out) {
        for (int i = 0; i < c->n; i++) {
            const int on = (limit[i] < 0) == (c->bt[i] >= 0.0);
            const int kind = !c->rough[i] || c->slides[i] ? ON : limit[i] == 0 ? HELD_FAST : on ? ON : BACK;
            way[i] = (signed char)(push[i] ? kind : LEAST_ON + kind);
        }
        wrong = of_way(c, way, A, x, column, Pn, Pt);
    }
    give_back(c->arena, mark);
    return wrong;
}

/* Which kinds contact i may be of, in a motion with the scaled rates vn and vt where `known`: their number */
static int kinds_of(const struct friction_problem *c, int i, int known, double vn, double vt, signed char *kinds)
{
    const int bound = c->least && c->least[i] > 0.0, free = c->rough[i] && !c->slides[i];
    const int slides = known && fabs(vt) > CONSISTENT, against = (vt < 0.0) == (c->bt[i] < 0.0);
    int count = 0;
    for (int kind = 0; kind < KINDS; kind++) {
        const int stays = kind < LEAST_ON, on = kind == ON || kind == LEAST_ON;
        if ((known && stays && vn > CONSISTENT) || (!free && !on) || (!stays && !bound && !on))
            continue;
        if (free && slides && (stays || bound) && (holds_fast(kind) || on != against))
            continue;
        kinds[count++] = (signed char)kind;
    }
    return count;
}

/* Whether impulses move as the rates do: 0 where not. */
static int same_motion(const struct friction_problem *c, const double *Pn, const double *Pt, const double *rates)
{
    double load, speed, size;
    sizes(c, Pn, Pt, &load, &speed);
    for (int row = 0; row < 2 * c->n; row++)
        if (fabs(rate_of(c, row, Pn, Pt, &size) - rates[row]) > ALIKE * (size + speed * c->root[row]))
            return 0;
    return 1;
}

/* Whether impulses add energy to the motion that has the rates c->from. */
static int adds(const struct friction_problem *c, const double *Pn, const double *Pt)
{
    const int n = c->n;
    double gain = 0.0, all = 0.0;
    for (int i = 0; c->from && i < 2 * n; i++) {
        const double P = i < n ? Pn[i] : Pt[i - n];
        double change = 0.0, size = 0.0;
        for (int j = 0; j < 2 * n; j++) {
            const double term = c->W[(size_t)i * 2 * n + j] * (j < n ? Pn[j] : Pt[j - n]);
            change += term;
            size += fabs(term);
        }
        gain += P * (c->from[i] + 0.5 * change);
        all += fabs(P) * (fabs(c->from[i]) + 0.5 * size);
    }
    return gain > RATE_ROUNDING * all;
}

struct search {
    double *A, *x, *Pn, *Pt, *rates;
    int *column, *count, *turn;
    signed char *kinds, *way;
};

/* Whether what rests in a known motion could push and be held in one way only: then so do the impulses. */
static int unique(const struct friction_problem *c, struct search *s)
{
    for (int i = 0; i < c->n; i++) {
        const signed char *kinds = s->kinds + i * KINDS;
        s->way[i] = kinds[0];
        for (int k = 0; k < s->count[i]; k++)
            s->way[i] = kinds[k] == HELD_FAST ? HELD_FAST : s->way[i];
    }
    return !of_way(c, s->way, s->A, s->x, s->column, s->Pn, s->Pt);
}

/* Whether no contact pulls, but for rounding: a part of `coulomb_residual` that most ways already break */
static int none_pulls(const struct friction_problem *c, const double *Pn, const double *Pt)
{
    double load, speed;
    sizes(c, Pn, Pt, &load, &speed);
    for (int i = 0; i < c->n; i++)
        if (c->root[i] * (Pn[i] - (c->least ? c->least[i] : 0.0)) < -CONSISTENT * load)
            return 0;
    return 1;
}

/* All ways, the last contact's changing fastest; the best so far is in Pn and Pt, where `found`. */
static int try_all(const struct friction_problem *c, struct search *s, int known, int found, double *Pn, double *Pt)
{
    const int n = c->n;
    double least = found ? loaded(c, Pn) : INFINITY;
    memset(s->turn, 0, n * sizeof *s->turn);
    for (int done = 0; !done;) {
        for (int i = 0; i < n; i++)
            s->way[i] = s->kinds[i * KINDS + s->turn[i]];
        if (!of_way(c, s->way, s->A, s->x, s->column, s->Pn, s->Pt) &&
            (!found || loaded(c, s->Pn) < (1.0 - LESS) * least) && none_pulls(c, s->Pn, s->Pt) &&
            coulomb_residual(c, s->Pn, s->Pt) <= CONSISTENT && !adds(c, s->Pn, s->Pt) &&
            (!known || same_motion(c, s->Pn, s->Pt, s->rates))) {
            memcpy(Pn, s->Pn, n * sizeof *Pn);
            memcpy(Pt, s->Pt, n * sizeof *Pt);
            least = loaded(c, Pn);
            found = 1;
        }
        int i = n - 1;
        while (i >= 0 && ++s->turn[i] == s->count[i])
            s->turn[i--] = 0;
        done = i < 0;
    }
    return found;
}

int least_impulses(const struct friction_problem *c, enum known given, double *Pn, double *Pt)
{
    const size_t n = c->n;
    const int known = given == MOTION;
    const struct mark mark = c->arena->top;
    struct search s = {
        .A = TAKE(c->arena, double, 4 * n * n),
        .x = TAKE(c->arena, double, 2 * n),
        .Pn = TAKE(c->arena, double, n),
        .Pt = TAKE(c->arena, double, n),
        .rates = TAKE(c->arena, double, 2 * n),
        .column = TAKE(c->arena, int, 2 * n),
        .count = TAKE(c->arena, int, n),
        .turn = TAKE(c->arena, int, n),
        .kinds = TAKE_ZEROS(c->arena, signed char, (KINDS * n)),
        .way = TAKE(c->arena, signed char, n),
    };
    double load, speed, size;
    long ways = 1;
    int result = 2;
    if (c->arena->ran_out)
        goto end;
    if (known)
        sizes(c, Pn, Pt, &load, &speed);
    for (int i = 0; i < c->n; i++) {
        const double vn = known ? scaled_rate(c, i, Pn, Pt, speed) : 0.0;
        const double vt = known ? scaled_rate(c, c->n + i, Pn, Pt, speed) : 0.0;
        s.count[i] = kinds_of(c, i, known, vn, vt, s.kinds + i * KINDS);
        ways *= ways <= MOST ? s.count[i] : 1;
    }
    for (int row = 0; known && row < 2 * c->n; row++)
        s.rates[row] = rate_of(c, row, Pn, Pt, &size);
    if (known && unique(c, &s))
        result = 0;
    else if (ways <= MOST)
        result = !try_all(c, &s, known, given != NOTHING, Pn, Pt);
end:
    give_back(c->arena, mark);
    return result;
}

/* The way that impulses have taken: they push where they are above their least, and friction that is not at its limit holds. */
static void way_of(const struct friction_problem *c, const double *Pn, const double *Pt, signed char *way)
{
    double load, speed;
    sizes(c, Pn, Pt, &load, &speed);
    for (int i = 0; i < c->n; i++) {
        const double extra = Pn[i] - (c->least ? c->least[i] : 0.0), limit = c->mu[i] * Pn[i];
        const int pushes = extra > 0.0 && scaled_rate(c, i, Pn, Pt, speed) <= CONSISTENT;
        const int limited = !(fabs(Pt[i]) < limit * (1.0 - 4.0 * DBL_EPSILON)),
                  on = (Pt[i] <= 0.0) == (c->bt[i] >= 0.0);
        const int kind = !c->rough[i] || c->slides[i] ? ON : !limited ? HELD_FAST : on ? ON : BACK;
        way[i] = (signed char)(pushes ? kind : LEAST_ON + kind);
    }
}

/* The rows that are at rest, also those of contacts that do not push: others may carry them, and know better what the motion is. */
static int rows_at_rest(const struct friction_problem *c, const double *Pn, const double *Pt, int *row)
{
    double load, speed;
    int rows = 0;
    sizes(c, Pn, Pt, &load, &speed);
    for (int i = 0; i < 2 * c->n; i++)
        if (c->root[i] > 0.0 && fabs(scaled_rate(c, i, Pn, Pt, speed)) <= CONSISTENT)
            row[rows++] = i;
    return rows;
}

void refine_impulses(const struct friction_problem *c, double *Pn, double *Pt)
{
    const size_t n = c->n;
    const struct mark mark = c->arena->top;
    double *A = TAKE(c->arena, double, 4 * n * n), *x = TAKE(c->arena, double, 2 * n);
    double *normal = TAKE(c->arena, double, n), *tangent = TAKE(c->arena, double, n);
    int *column = TAKE(c->arena, int, 2 * n), *order = TAKE(c->arena, int, 2 * n), *row = TAKE(c->arena, int, 2 * n);
    signed char *way = TAKE(c->arena, signed char, n);
    double worst = coulomb_residual(c, Pn, Pt);
    for (int pass = 0; !c->arena->ran_out && pass < REFINEMENTS; pass++) {
        way_of(c, Pn, Pt, way);
        for (int i = 0; i < c->n; i++) { /* what is not unknown is what its way says */
            normal[i] = way[i] < LEAST_ON ? Pn[i] : c->least ? c->least[i] : 0.0;
            tangent[i] = holds_fast(way[i]) ? Pt[i] : at_limit(c, i, way[i]) * normal[i];
        }
        const int m = unknowns_of_way(c, way, column), rows = rows_at_rest(c, Pn, Pt, row);
        rows_of_way(c, way, m, column, rows, row, normal, tangent, A, x);
        const int rank = eliminate_dependent(rows, m, A, x, order, SINGULAR_MODES);
        for (int j = 0; j < rank; j++)
            change(c, way, column[order[j]], x[j], normal, tangent);
        const double left = coulomb_residual(c, normal, tangent);
        if (!rank || !(left < worst))
            break;
        worst = left;
        memcpy(Pn, normal, n * sizeof *Pn);
        memcpy(Pt, tangent, n * sizeof *Pt);
    }
    give_back(c->arena, mark);
}
