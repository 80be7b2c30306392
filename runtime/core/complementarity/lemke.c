/* Linear complementarity by pivoting (C. E. Lemke, Management Science 11, 1965).
 *
 * Ties of the ratio test can send pivots in circles, or onto a ray where there is a solution. A shift of q breaks them: then the
 * tableau carries q beside the shifted one, which alone decides, and the solution is that of q in the last basis.
 */
#include "complementarity/lemke.h"

#include <math.h>
#include <string.h>

#include "base/tolerances.h"

enum { PIVOTS = 50 /* per unknown */ };

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

/* Which row leaves for the entering column: the first whose value comes to 0; among ties the cover, else the largest pivot; -1
 * on a ray. */
static int leaving_row(int m, int width, const double *T, const int *basis, int entering, double scale)
{
    int row = -1;
    double best = INFINITY;
    for (int i = 0; i < m; i++) {
        const double d = T[(size_t)i * width + entering];
        if (d <= PIVOT_ROUNDING)
            continue;
        const double ratio = fmax(T[(size_t)i * width + width - 1], 0.0) / d;
        const double tie = TIE * (scale + ratio);
        if (ratio < best - tie ||
            (ratio <= best + tie &&
             (basis[i] == 2 * m || (row >= 0 && basis[row] != 2 * m && d > T[(size_t)row * width + entering])))) {
            best = ratio < best ? ratio : best;
            row = i;
        }
    }
    return row;
}

/* The tableau of w, z, the cover, q and the shifted q; returns the row that the cover enters, or -1 where q >= 0. */
static int start(int m, const double *M, const double *q, const double *cover, const double *shift, double *T,
                 int *basis, double *scale)
{
    const int width = 2 * m + 3;
    int row = -1;
    double worst = 0.0;
    for (int i = 0; i < m; i++) {
        double *r = T + (size_t)i * width;
        const double covered = cover ? cover[i] : 1.0, value = q[i] + (shift ? shift[i] : 0.0);
        *scale = fmax(*scale, fabs(q[i]));
        r[i] = 1.0;
        for (int j = 0; j < m; j++)
            r[m + j] = -M[i * m + j];
        r[2 * m] = -covered;
        r[2 * m + 1] = q[i];
        r[2 * m + 2] = value;
        basis[i] = i;
        if (value / covered < worst) {
            worst = value / covered;
            row = i;
        }
    }
    return row;
}

int lemke(struct arena *arena, int m, const double *M, const double *q, const double *cover, const double *shift,
          double *z, char *in)
{
    const int width = 2 * m + 3;
    const struct mark mark = arena->top;
    double *T = TAKE_ZEROS(arena, double, ((size_t)m * width)), scale = 0.0;
    int *basis = TAKE(arena, int, m), result = 2;
    memset(z, 0, m * sizeof *z);
    memset(in, 0, m);
    if (arena->ran_out)
        goto end;
    int row = start(m, M, q, cover, shift, T, basis, &scale), entering = 2 * m;
    result = row < 0 ? 0 : 2;
    for (int step = 0; step < PIVOTS * (m + 1) && result == 2; step++) {
        const int leaving = basis[row];
        pivot(m, width, T, row, entering);
        basis[row] = entering;
        entering = leaving < m ? leaving + m : leaving - m;
        if (leaving == 2 * m)
            result = 0;
        else if ((row = leaving_row(m, width, T, basis, entering, scale)) < 0)
            result = 1;
    }
    for (int i = 0; i < m; i++)
        if (basis[i] >= m && basis[i] < 2 * m) {
            z[basis[i] - m] = fmax(T[(size_t)i * width + 2 * m + 1], 0.0);
            in[basis[i] - m] = 1;
        }
end:
    give_back(arena, mark);
    return result;
}
