/* Flights by Gauss collocation with fixed steps, which sweep until stages do not change: what fills the lanes of the machine, the
 * stages of one run, as in the core, or LANES runs. Built and called by shared_lanes.py. */
#define _POSIX_C_SOURCE 199309L
#include <math.h>
#include <string.h>
#include <time.h>

#include "gauss_tableau.h"
#include "model.h"

enum { MOST = 16, BLOCKS = STAGES / LANES, SWEEPS = 50 };

typedef double lanes __attribute__((vector_size(8 * LANES)));

struct flight {
    const struct ccgen_model *model;
    const double *constants;
    double *multipliers; /* [rows][lanes], room */
    int n, steps;
    double h, tolerance;
};

static const double TIMES[LANES];

/* carried[j][i]: what stage j gives to stage i of the next step of the same length, by the polynomial through all */
static void carry_on(double carried[STAGES][STAGES])
{
    for (int i = 0; i < STAGES; i++)
        for (int j = 0; j < STAGES; j++) {
            carried[j][i] = 1.0;
            for (int k = 0; k < STAGES; k++)
                if (k != j)
                    carried[j][i] *= (1.0 + NODE[i] - NODE[k]) / (NODE[j] - NODE[k]);
        }
}

/* One run, its stages in lanes; how many sweeps */
static long by_stages(const struct flight *w, double *q, double *u)
{
    const int n = w->n;
    const double h = w->h;
    lanes f[BLOCKS][MOST], qs[MOST], us[MOST], found[BLOCKS][MOST], once[STAGES][BLOCKS], twice[STAGES][BLOCKS],
        on[STAGES][BLOCKS], node[BLOCKS];
    double carried[STAGES][STAGES], first[MOST];
    long sweeps = 0;
    carry_on(carried);
    for (int i = 0; i < STAGES; i++) {
        node[i / LANES][i % LANES] = NODE[i];
        for (int j = 0; j < STAGES; j++) {
            once[j][i / LANES][i % LANES] = h * ONCE[j][i];
            twice[j][i / LANES][i % LANES] = h * h * TWICE[j][i];
            on[j][i / LANES][i % LANES] = carried[j][i];
        }
    }
    w->model->acceleration(w->constants, q, u, 0.0, 0, first, w->multipliers);
    for (int b = 0; b < BLOCKS; b++)
        for (int i = 0; i < n; i++)
            f[b][i] = first[i] + (lanes){0};
    for (int step = 0; step < w->steps; step++) {
        double change = INFINITY;
        for (int sweep = 0; sweep < SWEEPS && h * change > w->tolerance; sweep++, sweeps++) {
            change = 0.0;
            for (int b = 0; b < BLOCKS; b++) {
                for (int i = 0; i < n; i++) {
                    lanes a = {0}, c = {0};
                    for (int j = 0; j < STAGES; j++) {
                        a += once[j][b] * f[j / LANES][i][j % LANES];
                        c += twice[j][b] * f[j / LANES][i][j % LANES];
                    }
                    qs[i] = q[i] + node[b] * (h * u[i]) + c;
                    us[i] = u[i] + a;
                }
                w->model->acceleration_lanes(w->constants, (double *)qs, (double *)us, TIMES, 0, (double *)found[b],
                                             w->multipliers);
            }
            for (int b = 0; b < BLOCKS; b++)
                for (int i = 0; i < n; i++)
                    for (int l = 0; l < LANES; l++)
                        change = fmax(change, fabs(found[b][i][l] - f[b][i][l]));
            memcpy(f, found, sizeof f);
        }
        for (int i = 0; i < n; i++) {
            double dq = h * u[i], du = 0.0;
            lanes next[BLOCKS] = {{0}};
            for (int j = 0; j < STAGES; j++) {
                const double value = f[j / LANES][i][j % LANES];
                dq += h * h * WEIGHT2[j] * value;
                du += h * WEIGHT[j] * value;
                for (int b = 0; b < BLOCKS; b++)
                    next[b] += on[j][b] * value;
            }
            q[i] += dq;
            u[i] += du;
            for (int b = 0; b < BLOCKS; b++)
                f[b][i] = next[b];
        }
    }
    return sweeps;
}

/* LANES runs, one in each lane, their stages one after the other; what a stage has found is used in the same sweep where `at_once` */
static long by_runs(const struct flight *w, lanes *q, lanes *u, int at_once)
{
    const int n = w->n;
    const double h = w->h;
    lanes rooms[2][STAGES][MOST], qs[MOST], us[MOST], first[MOST];
    lanes(*f)[MOST] = rooms[0], (*found)[MOST] = rooms[1];
    double carried[STAGES][STAGES], once[STAGES][STAGES], twice[STAGES][STAGES];
    long sweeps = 0;
    carry_on(carried);
    for (int s = 0; s < STAGES; s++)
        for (int j = 0; j < STAGES; j++) {
            once[s][j] = h * ONCE[j][s];
            twice[s][j] = h * h * TWICE[j][s];
        }
    w->model->acceleration_lanes(w->constants, (double *)q, (double *)u, TIMES, 0, (double *)first, w->multipliers);
    for (int s = 0; s < STAGES; s++)
        memcpy(f[s], first, sizeof first);
    for (int step = 0; step < w->steps; step++) {
        double change = INFINITY;
        for (int sweep = 0; sweep < SWEEPS && h * change > w->tolerance; sweep++, sweeps++) {
            change = 0.0;
            for (int s = 0; s < STAGES; s++) {
                for (int i = 0; i < n; i++) {
                    lanes a = {0}, c = {0};
                    for (int j = 0; j < STAGES; j++) {
                        a += once[s][j] * f[j][i];
                        c += twice[s][j] * f[j][i];
                    }
                    qs[i] = q[i] + h * NODE[s] * u[i] + c;
                    us[i] = u[i] + a;
                }
                w->model->acceleration_lanes(w->constants, (double *)qs, (double *)us, TIMES, 0, (double *)found[s],
                                             w->multipliers);
                for (int i = 0; i < n; i++)
                    for (int l = 0; l < LANES; l++)
                        change = fmax(change, fabs(found[s][i][l] - f[s][i][l]));
                for (int i = 0; i < n && at_once; i++)
                    f[s][i] = found[s][i];
            }
            lanes(*const older)[MOST] = f;
            f = found;
            found = older;
        }
        for (int i = 0; i < n; i++) {
            lanes dq = h * u[i], du = {0}, next[STAGES] = {{0}};
            for (int j = 0; j < STAGES; j++) {
                dq += h * h * WEIGHT2[j] * f[j][i];
                du += h * WEIGHT[j] * f[j][i];
                for (int s = 0; s < STAGES; s++)
                    next[s] += carried[j][s] * f[j][i];
            }
            q[i] += dq;
            u[i] += du;
            for (int s = 0; s < STAGES; s++)
                f[s][i] = next[s];
        }
    }
    return sweeps;
}

/* Fly `runs`, a multiple of LANES, from q, u [runs][n], which then hold the ends: way 0 by stages, 1 by runs, 2 by runs at once.
 * Seconds; sweeps of all runs into *sweeps. */
double fly(const struct flight *w, int way, int runs, double *q, double *u, long *sweeps)
{
    struct timespec begun, ended;
    clock_gettime(CLOCK_MONOTONIC, &begun);
    *sweeps = 0;
    for (int run = 0; run < runs && way == 0; run++)
        *sweeps += by_stages(w, q + run * w->n, u + run * w->n);
    for (int run = 0; run < runs && way; run += LANES) {
        lanes side[MOST], speed[MOST];
        for (int i = 0; i < w->n; i++)
            for (int l = 0; l < LANES; l++) {
                side[i][l] = q[(run + l) * w->n + i];
                speed[i][l] = u[(run + l) * w->n + i];
            }
        *sweeps += LANES * by_runs(w, side, speed, way == 2);
        for (int i = 0; i < w->n; i++)
            for (int l = 0; l < LANES; l++) {
                q[(run + l) * w->n + i] = side[i][l];
                u[(run + l) * w->n + i] = speed[i][l];
            }
    }
    clock_gettime(CLOCK_MONOTONIC, &ended);
    return (double)(ended.tv_sec - begun.tv_sec) + 1e-9 * (double)(ended.tv_nsec - begun.tv_nsec);
}
