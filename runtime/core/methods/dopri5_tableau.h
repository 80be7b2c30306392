/* Coefficients of Dormand-Prince 5(4) and of L. F. Shampine's interpolant (E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary
 * Differential Equations I, 1993, sections II.5 and II.6). The tests check them against the conditions that define them. */
#ifndef CCGEN_DOPRI5_TABLEAU_H
#define CCGEN_DOPRI5_TABLEAU_H

#pragma GCC system_header /* numbers have the digits of long doubles, and are rounded to the core's type without a warning */

enum { STAGES = 7 };

static const double C[STAGES] = {0.0, 0.2L, 0.3L, 0.8L, 8.0L / 9.0L, 1.0, 1.0};

/* The last row is the solution of order 5, too. */
static const double A[STAGES][STAGES] = {
    {0.0},
    {0.2L},
    {3.0L / 40.0L, 9.0L / 40.0L},
    {44.0L / 45.0L, -56.0L / 15.0L, 32.0L / 9.0L},
    {19372.0L / 6561.0L, -25360.0L / 2187.0L, 64448.0L / 6561.0L, -212.0L / 729.0L},
    {9017.0L / 3168.0L, -355.0L / 33.0L, 46732.0L / 5247.0L, 49.0L / 176.0L, -5103.0L / 18656.0L},
    {35.0L / 384.0L, 0.0, 500.0L / 1113.0L, 125.0L / 192.0L, -2187.0L / 6784.0L, 11.0L / 84.0L}};

/* solution of order 5 less that of order 4 */
static const double E[STAGES] = {
    71.0L / 57600.0L, 0.0, -71.0L / 16695.0L, 71.0L / 1920.0L, -17253.0L / 339200.0L, 22.0L / 525.0L, -1.0L / 40.0L};

/* last coefficient of the interpolant */
static const double D[STAGES] = {-12715105075.0L / 11282082432.0L,  0.0,
                                 87487479700.0L / 32700410799.0L,   -10690763975.0L / 1880347072.0L,
                                 701980252875.0L / 199316789632.0L, -1453857185.0L / 822651844.0L,
                                 69997945.0L / 29380423.0L};

#endif
