/* Times acceleration kernels from C: batches of calls that cycle through given states, taken in turn.
 *
 * Built and loaded by driver.py, which mirrors `struct kernel`.
 */
#define _POSIX_C_SOURCE 199309L
#include <time.h>

#include "model.h"

enum kind { CCGEN, CASADI, CCGEN_LANES };

typedef int casadi_function(const double **arguments, double **results, long long *iw, double *w, int memory);

struct kernel {
    int kind;             /* enum kind */
    int states;           /* number of states */
    int nq, nu;           /* lengths of q and u */
    const void *target;   /* const struct ccgen_model *, or casadi_function * */
    const double *q, *u;  /* (states, nq), (states, nu); over lanes (states / lanes, nq, lanes), (.., nu, lanes) */
    double *u_dot;        /* (states, nu), result; over lanes as u */
    double *constants;    /* ccgen: (constants,) */
    double *multipliers;  /* ccgen: (rows,), over lanes (rows, lanes) */
};

typedef void call(const struct kernel *kernel, const double *q, const double *u, double *u_dot);

static inline void call_ccgen(const struct kernel *kernel, const double *q, const double *u, double *u_dot)
{
    const struct ccgen_model *model = kernel->target;
    model->acceleration(kernel->constants, q, u, 0.0, 0, u_dot, kernel->multipliers);
}

static inline void call_casadi(const struct kernel *kernel, const double *q, const double *u, double *u_dot)
{
    casadi_function *function = (casadi_function *)kernel->target;
    const double *arguments[] = {q, u};
    double *results[] = {u_dot};
    function(arguments, results, 0, 0, 0);
}

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Seconds that `calls` evaluations take; inlined into `batch`, so that `evaluate` is known there. */
static inline __attribute__((always_inline)) double timed(call *evaluate, const struct kernel *kernel, long calls)
{
    const double start = now();
    for (long i = 0, state = 0; i < calls; i++) {
        evaluate(kernel, kernel->q + state * kernel->nq, kernel->u + state * kernel->nu,
                 kernel->u_dot + state * kernel->nu);
        state = state + 1 < kernel->states ? state + 1 : 0;
    }
    return now() - start;
}

/* Seconds that `calls` states take, as many at a time as the model has lanes. */
static double timed_lanes(const struct kernel *kernel, long calls)
{
    const struct ccgen_model *model = kernel->target;
    const double t[16] = {0.0}, start = now();
    const long block = (long)model->lanes;
    for (long i = 0, state = 0; i < calls; i += block) {
        model->acceleration_lanes(kernel->constants, kernel->q + state * kernel->nq, kernel->u + state * kernel->nu, t, 0,
                                  kernel->u_dot + state * kernel->nu, kernel->multipliers);
        state = state + block < kernel->states ? state + block : 0;
    }
    return now() - start;
}

/* Sizes of a model's working arrays. */
void sizes(const struct ccgen_model *model, int *constants, int *rows)
{
    *constants = model->constants;
    *rows = model->rows;
}

/* constants[constants] of a model from parameters[parameters]. */
void derive(const struct ccgen_model *model, const double *parameters, double *constants)
{
    model->derive_constants(parameters, constants);
}

/* Seconds that `calls` evaluations of one kernel take, one state after the other. */
double batch(const struct kernel *kernel, long calls)
{
    if (kernel->kind == CCGEN_LANES)
        return timed_lanes(kernel, calls);
    return kernel->kind == CCGEN ? timed(call_ccgen, kernel, calls) : timed(call_casadi, kernel, calls);
}

/* Seconds per evaluation, seconds (rounds, kernels): in each round every kernel has one batch of about `length` s. */
void interleave(const struct kernel *kernels, int count, int rounds, double length, double *seconds)
{
    long calls[64];
    for (int j = 0; j < count; j++)
        for (calls[j] = kernels[j].states; batch(&kernels[j], calls[j]) < length; calls[j] *= 2)
            ;
    for (int i = 0; i < rounds; i++)
        for (int j = 0; j < count; j++)
            seconds[i * count + j] = batch(&kernels[j], calls[j]) / (double)calls[j];
}
