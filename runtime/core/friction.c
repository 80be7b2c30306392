/* Coulomb friction at contacts in the plane as one complementarity problem.
 *
 * With r = mu Pn + Pt and l = mu Pn - Pt, the two distances of a tangential impulse from its limits, and the sliding split
 * into its forward and backward part, vt = vr - vl,
 *
 *     vn = Gnn Pn + Gnt Pt + bn,   vt = Gtn Pn + Gtt Pt + bt,   l = 2 mu Pn - r,
 *     0 <= (Pn, r, vl)  complementary to  (vn, vr, l) >= 0 ,
 *
 * which is linear in (Pn, r, vl) (F. Pfeiffer, C. Glocker, Multibody Dynamics with Unilateral Contacts, 1996, section 8).
 * A contact known to slide needs its normal row alone, with Pt = -mu Pn forward. Solved by complementary pivoting (C. E.
 * Lemke, Management Science 11, 1965); where that ends on a ray there is no solution: friction jams (Painleve).
 */
#include "friction.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { PIVOTS = 50 /* per unknown */, SWEEPS = 20000 };

/* One pivot of the tableau T[m][width] on (row, column). */
static void pivot(int m, int width, double *T, int row, int column)
{
    double *p = T + (size_t)row * width;
    const double inverse = 1.0 / p[column];
    for (int j = 0; j < width; j++)
        p[j] *= inverse;
    p[column] = 1.0;
    for (int i = 0; i < m; i++) {
        double *r = T + (size_t)i * width;
        const double factor = r[column];
        if (i == row || factor == 0.0)
            continue;
        for (int j = 0; j < width; j++)
            r[j] -= factor * p[j];
        r[column] = 0.0;
    }
}

/* 0 <= z, 0 <= w = M z + q, z.w = 0 by Lemke's method; as solve_friction. */
static int lemke(int m, const double *M, const double *q, double *z)
{
    const int width = 2 * m + 2, last = width - 1;
    double *T = calloc((size_t)m * width, sizeof *T);
    int *basis = malloc((m + 1) * sizeof *basis);
    int result = 2, row = -1;
    double scale = 0.0;
    memset(z, 0, m * sizeof *z);
    if (!T || !basis)
        goto end;
    for (int i = 0; i < m; i++) {
        scale = fmax(scale, fabs(q[i]));
        T[(size_t)i * width + i] = 1.0;
        for (int j = 0; j < m; j++)
            T[(size_t)i * width + m + j] = -M[i * m + j];
        T[(size_t)i * width + 2 * m] = -1.0;
        T[(size_t)i * width + last] = q[i];
        basis[i] = i;
        if (q[i] < (row < 0 ? 0.0 : q[row]))
            row = i;
    }
    if (row < 0) {
        result = 0;
        goto end;
    }
    int entering = 2 * m;
    for (int step = 0; step < PIVOTS * (m + 1); step++) {
        const int leaving = basis[row];
        pivot(m, width, T, row, entering);
        basis[row] = entering;
        if (leaving == 2 * m) {
            result = 0;
            break;
        }
        entering = leaving < m ? leaving + m : leaving - m;
        row = -1;
        double best = INFINITY;
        for (int i = 0; i < m; i++) {
            const double d = T[(size_t)i * width + entering];
            if (d <= 1e-12)
                continue;
            const double ratio = fmax(T[(size_t)i * width + last], 0.0) / d;
            const double tie = 1e-13 * (scale + ratio);
            if (ratio < best - tie || (ratio <= best + tie && (basis[i] == 2 * m || (row >= 0 && basis[row] != 2 * m &&
                                                                                      d > T[(size_t)row * width + entering])))) {
                best = ratio < best ? ratio : best;
                row = i;
            }
        }
        if (row < 0) {
            result = 1;
            break;
        }
    }
    for (int i = 0; i < m; i++)
        if (basis[i] >= m && basis[i] < 2 * m)
            z[basis[i] - m] = fmax(T[(size_t)i * width + last], 0.0);
end:
    free(T);
    free(basis);
    return result;
}

static double row_rate(int n, const double *W, int i, double b, const double *Pn, const double *Pt)
{
    for (int j = 0; j < n; j++)
        b += W[(size_t)i * 2 * n + j] * Pn[j] + W[(size_t)i * 2 * n + n + j] * Pt[j];
    return b;
}

/* The same contact by contact, again and again, for what pivoting has lost in rounding: 0, or 1 if it does not settle. */
static int sweep(int n, const double *W, const double *bn, const double *bt, const double *mu, const signed char *slide,
                 const double *least, double *Pn, double *Pt)
{
    memset(Pn, 0, n * sizeof *Pn);
    memset(Pt, 0, n * sizeof *Pt);
    for (int pass = 0; pass < SWEEPS; pass++) {
        double change = 0.0, largest = 0.0;
        for (int i = 0; i < n; i++) {
            const double nn = W[(size_t)i * 2 * n + i], nt = W[(size_t)i * 2 * n + n + i];
            const double tt = W[(size_t)(n + i) * 2 * n + n + i], floor = least ? least[i] : 0.0;
            const double own = nn - slide[i] * mu[i] * nt, was = Pn[i], pulled = Pt[i];
            if (!(own > 0.0))
                return 1;
            Pn[i] = fmax(floor, was - row_rate(n, W, i, bn[i], Pn, Pt) / own);
            const double limit = mu[i] * Pn[i];
            Pt[i] = slide[i] ? -slide[i] * limit : fmin(fmax(pulled, -limit), limit);
            if (!slide[i] && limit > 0.0)
                Pt[i] = fmin(fmax(Pt[i] - row_rate(n, W, n + i, bt[i], Pn, Pt) / tt, -limit), limit);
            change = fmax(change, fmax(fabs(Pn[i] - was), fabs(Pt[i] - pulled)));
            largest = fmax(largest, Pn[i]);
        }
        if (change <= 1e-15 * largest)
            return 0;
    }
    return 1;
}

int solve_friction(int n, const double *W, const double *bn, const double *bt, const double *mu, const signed char *slide,
                   const double *least, double *Pn, double *Pt)
{
    int m = n, result = 2;
    int *place = malloc((n + 1) * sizeof *place);
    double *work = calloc((size_t)9 * n * n + 7 * n + 1, sizeof *work);
    if (!place || !work)
        goto end;
    for (int i = 0; i < n; i++) { /* where r of a contact stands, vl behind it */
        place[i] = mu[i] > 0.0 && !slide[i] ? m : -1;
        m += place[i] < 0 ? 0 : 2;
    }
    double *M = work, *q = M + (size_t)m * m, *z = q + m, *k = z + m;
    for (int i = 0; i < n; i++)
        k[i] = slide[i] ? slide[i] * mu[i] : mu[i];
    for (int i = 0; i < n; i++)
        for (int t = 0; t < (place[i] < 0 ? 1 : 2); t++) {
            const double *row = W + (size_t)(i + t * n) * 2 * n;
            const int r = t ? place[i] : i;
            q[r] = t ? bt[i] : bn[i];
            for (int j = 0; j < n; j++) {
                M[r * m + j] = row[j] - row[n + j] * k[j];
                if (least)
                    q[r] += M[r * m + j] * least[j];
                if (place[j] >= 0)
                    M[r * m + place[j]] = row[n + j];
            }
            if (t) {
                M[r * m + r + 1] = 1.0;
                M[(r + 1) * m + i] = 2.0 * mu[i];
                M[(r + 1) * m + r] = -1.0;
                q[r + 1] = least ? 2.0 * mu[i] * least[i] : 0.0;
            }
        }
    result = lemke(m, M, q, z);
    for (int i = 0; i < n && !result; i++) {
        Pn[i] = z[i] + (least ? least[i] : 0.0);
        Pt[i] = place[i] < 0 ? -k[i] * Pn[i] : z[place[i]] - mu[i] * Pn[i];
    }
    if (result && !sweep(n, W, bn, bt, mu, slide, least, Pn, Pt))
        result = 0;
end:
    free(place);
    free(work);
    return result;
}
