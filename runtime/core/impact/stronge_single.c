/* Stronge's law at one contact: restitution gives back e^2 times the work that the normal impulse has taken in compression
 * (W. J. Stronge, Impact Mechanics, 2000, sections 3.3 and 4.2).
 *
 * The impact is a process whose time is the normal impulse p. With the friction that belongs to the present sliding,
 * f = -mu sign(vt), or what sticking needs,
 *
 *     dvn/dp = Wnn + Wnt f,    dvt/dp = Wtn + Wtt f,    d(work)/dp = vn,
 *
 * all piecewise linear in p: from the end of sliding, of compression or of restitution to the next.
 *
 * Where the mechanism has one degree of freedom, W has rank 1: sliding and compression end at the same p, and where friction
 * can then hold the point (mu >= |Wnn / Wnt|) it is a wedge: no further p moves it, and it gives nothing back. Rounding would
 * keep those two ends apart and let a held point creep, so what is within it counts as equal and as 0.
 */
#include "impact/stronge_single.h"

#include <float.h>
#include <math.h>

#include "base/tolerances.h"
#include "impact/problem.h"

enum { PIECES = 32 };

/* Whether no impulse moves the point along the ground. */
static int constrained_tangentially(const double *W)
{
    return W[3] <= DBL_EPSILON * W[0] && fabs(W[2]) <= RATE_ROUNDING * W[0];
}

/* Friction per normal impulse: against the sliding vt; at its end what keeps it at rest, or where that is more than mu the
 * limit against the sliding that begins. */
static double friction_of(const double *W, double mu, double vt)
{
    if (mu == 0.0)
        return 0.0;
    if (vt != 0.0)
        return vt > 0.0 ? -mu : mu;
    if (constrained_tangentially(W))
        return 0.0;
    return fabs(W[2]) <= mu * W[3] ? -W[2] / W[3] : copysign(mu, -W[2]);
}

int stronge_single(const double *W, double mu, double e, const double *rate, double *P, double *F)
{
    const double size = fmax(W[0], W[3]);
    double vn = rate[0], vt = mu > 0.0 ? rate[1] : 0.0, taken = 0.0, given = 0.0;
    *P = *F = 0.0;
    if (constrained_tangentially(W) && fabs(vt) <= RATE_ROUNDING * fabs(vn))
        vt = 0.0;
    for (int piece = 0; piece < PIECES; piece++) {
        const double f = friction_of(W, mu, vt), speeds = W[0] + W[1] * f;
        const int sticking = vt == 0.0 && fabs(f) < mu;
        const double a = fabs(speeds) <= RATE_ROUNDING * (vt == 0.0 && f != 0.0 ? size : W[0]) ? 0.0 : speeds;
        const double c = sticking ? 0.0 : W[2] + W[3] * f;
        const int compressing = vn < 0.0 || (vn == 0.0 && a < 0.0);
        const int wedged = vn == 0.0 && vt == 0.0 && a == 0.0;
        if (wedged || (!compressing && given >= e * e * taken))
            return 0;
        const double turns = vt * c < 0.0 ? -vt / c : INFINITY;
        const double meets = vn * a < 0.0 ? -vn / a : INFINITY; /* the end of compression, or its return */
        const double ends = compressing ? INFINITY : until_work(vn, a, e * e * taken - given);
        const double small = RATE_ROUNDING * (fabs(vn) + fabs(vt) + size * turns);
        const int together = isfinite(turns) && isfinite(meets) && fabs(vn + a * turns) <= small;
        const double dp = fmin(together ? turns : fmin(turns, meets), ends);
        if (!isfinite(dp))
            return 1;
        const double work = vn * dp + 0.5 * a * dp * dp;
        *(compressing ? &taken : &given) += compressing ? -work : work;
        *P += dp;
        *F += f * dp;
        if (dp == ends)
            return 0;
        vn = together || dp == meets ? 0.0 : vn + a * dp;
        vt = together || dp == turns ? 0.0 : vt + c * dp;
    }
    return 1;
}
