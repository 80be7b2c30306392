/* Accelerations of a model in flight as an external function of CasADi, x[p] = (q, u, inputs) to u_dot[n], with its Jacobian.
 *
 * A file that AccelerationFunction.write_casadi writes includes this once, behind EXTERNAL, the function's name, EXTERNAL_MODEL,
 * EXTERNAL_SETTINGS, EXTERNAL_T (s), EXTERNAL_N and EXTERNAL_INPUTS. The names that CasADi asks a library for, and how it calls them, are those of
 * the C that it generates itself (CasADi's documentation, "The external class").
 */
#include <stdatomic.h>
#include <stddef.h>
#include <stdio.h>

#include "ccgen.h"

#ifdef _WIN32
#define EXTERNAL_PUBLIC __declspec(dllexport)
#else
#define EXTERNAL_PUBLIC __attribute__((visibility("default")))
#endif

#define EXTERNAL_JOINED(a, b) a##b
#define EXTERNAL_EXPANDED(a, b) EXTERNAL_JOINED(a, b)
#define EXTERNAL_CALLED(what) EXTERNAL_EXPANDED(EXTERNAL, what)
#define EXTERNAL_QUOTED(name) #name
#define EXTERNAL_TEXT(name) EXTERNAL_QUOTED(name)
#define EXTERNAL_JACOBIAN EXTERNAL_EXPANDED(jac_, EXTERNAL)
#define EXTERNAL_JACOBIAN_CALLED(what) EXTERNAL_EXPANDED(EXTERNAL_JACOBIAN, what)

typedef long long casadi_int;

enum { EXTERNAL_P = 2 * EXTERNAL_N + EXTERNAL_INPUTS, EXTERNAL_THREADS = 64 };

/* A simulation for each call that runs at the same time; what has been made is kept until CasADi lets the function go. */
static struct ccgen_simulation *external_made[EXTERNAL_THREADS];
static atomic_int external_taken[EXTERNAL_THREADS], external_users;

/* Say why a call has failed, which CasADi does not ask for. */
static int external_said(int code)
{
    if (code)
        fprintf(stderr, "%s: no acceleration: %s\n", EXTERNAL_TEXT(EXTERNAL), ccgen_outcome_name(code));
    return code != 0;
}

static int external_take(void)
{
    for (int i = 0; i < EXTERNAL_THREADS; i++) {
        int nobody = 0;
        if (!atomic_compare_exchange_strong(&external_taken[i], &nobody, 1))
            continue;
        if (external_made[i] || !external_said(ccgen_create(&EXTERNAL_MODEL, &EXTERNAL_SETTINGS, &external_made[i])))
            return i;
        atomic_store(&external_taken[i], 0);
        return -1;
    }
    fprintf(stderr,
            "%s: no acceleration: found more calls at once than %d, expected as many at most; use fewer threads\n",
            EXTERNAL_TEXT(EXTERNAL), EXTERNAL_THREADS);
    return -1;
}

static void external_let_go(int which)
{
    if (which >= 0)
        atomic_store(&external_taken[which], 0);
}

static void external_begin(void)
{
    atomic_fetch_add(&external_users, 1);
}

static void external_end(void)
{
    if (atomic_fetch_sub(&external_users, 1) > 1)
        return;
    for (int i = 0; i < EXTERNAL_THREADS; i++) {
        ccgen_destroy(external_made[i]);
        external_made[i] = NULL;
    }
}

static const casadi_int external_x[3] = {EXTERNAL_P, 1, 1}, external_value[3] = {EXTERNAL_N, 1, 1};
static const casadi_int external_jacobian[3] = {EXTERNAL_N, EXTERNAL_P, 1};

/* x where CasADi leaves out what is zero */
static const double *external_given(const double *x)
{
    static const double zeros[EXTERNAL_P];
    return x ? x : zeros;
}

EXTERNAL_PUBLIC int EXTERNAL(const double **arg, double **res, casadi_int *iw, double *w, int which)
{
    const double *x = external_given(arg[0]);
    (void)iw;
    (void)w;
    if (!res[0])
        return 0;
    if (which < 0)
        return 1;
    return external_said(
        ccgen_find_acceleration(external_made[which], EXTERNAL_T, x, x + EXTERNAL_N, x + 2 * EXTERNAL_N, res[0]));
}

/* w[n + n p]: u_dot, which is asked for no more, and the Jacobian row by row; CasADi has it column by column. */
EXTERNAL_PUBLIC int EXTERNAL_JACOBIAN(const double **arg, double **res, casadi_int *iw, double *w, int which)
{
    const double *x = external_given(arg[0]);
    double *by_q = w + EXTERNAL_N, *by_u = by_q + EXTERNAL_N * EXTERNAL_N, *by_inputs = by_u + EXTERNAL_N * EXTERNAL_N;
    (void)iw;
    if (!res[0])
        return 0;
    if (which < 0 || external_said(ccgen_derive_acceleration(external_made[which], EXTERNAL_T, x, x + EXTERNAL_N,
                                                             x + 2 * EXTERNAL_N, w, by_q, by_u, by_inputs)))
        return 1;
    for (int i = 0; i < EXTERNAL_N; i++) {
        for (int j = 0; j < EXTERNAL_N; j++) {
            res[0][j * EXTERNAL_N + i] = by_q[i * EXTERNAL_N + j];
            res[0][(EXTERNAL_N + j) * EXTERNAL_N + i] = by_u[i * EXTERNAL_N + j];
        }
        for (int j = 0; j < EXTERNAL_INPUTS; j++)
            res[0][(2 * EXTERNAL_N + j) * EXTERNAL_N + i] = by_inputs[i * EXTERNAL_INPUTS + j];
    }
    return 0;
}

EXTERNAL_PUBLIC casadi_int EXTERNAL_CALLED(_n_in)(void)
{
    return 1;
}

EXTERNAL_PUBLIC casadi_int EXTERNAL_CALLED(_n_out)(void)
{
    return 1;
}

EXTERNAL_PUBLIC const char *EXTERNAL_CALLED(_name_in)(casadi_int i)
{
    return i ? NULL : "x";
}

EXTERNAL_PUBLIC const char *EXTERNAL_CALLED(_name_out)(casadi_int i)
{
    return i ? NULL : "u_dot";
}

EXTERNAL_PUBLIC const casadi_int *EXTERNAL_CALLED(_sparsity_in)(casadi_int i)
{
    return i ? NULL : external_x;
}

EXTERNAL_PUBLIC const casadi_int *EXTERNAL_CALLED(_sparsity_out)(casadi_int i)
{
    return i ? NULL : external_value;
}

EXTERNAL_PUBLIC int EXTERNAL_CALLED(_work)(casadi_int *sz_arg, casadi_int *sz_res, casadi_int *sz_iw, casadi_int *sz_w)
{
    *sz_arg = *sz_res = 1;
    *sz_iw = *sz_w = 0;
    return 0;
}

EXTERNAL_PUBLIC int EXTERNAL_CALLED(_checkout)(void)
{
    return external_take();
}

EXTERNAL_PUBLIC void EXTERNAL_CALLED(_release)(int which)
{
    external_let_go(which);
}

EXTERNAL_PUBLIC void EXTERNAL_CALLED(_incref)(void)
{
    external_begin();
}

EXTERNAL_PUBLIC void EXTERNAL_CALLED(_decref)(void)
{
    external_end();
}

/* The Jacobian reads x and the value, which it does not need. */
EXTERNAL_PUBLIC casadi_int EXTERNAL_JACOBIAN_CALLED(_n_in)(void)
{
    return 2;
}

EXTERNAL_PUBLIC casadi_int EXTERNAL_JACOBIAN_CALLED(_n_out)(void)
{
    return 1;
}

EXTERNAL_PUBLIC const char *EXTERNAL_JACOBIAN_CALLED(_name_in)(casadi_int i)
{
    return i == 0 ? "x" : i == 1 ? "out_u_dot" : NULL;
}

EXTERNAL_PUBLIC const char *EXTERNAL_JACOBIAN_CALLED(_name_out)(casadi_int i)
{
    return i ? NULL : "jac_u_dot_x";
}

EXTERNAL_PUBLIC const casadi_int *EXTERNAL_JACOBIAN_CALLED(_sparsity_in)(casadi_int i)
{
    return i == 0 ? external_x : i == 1 ? external_value : NULL;
}

EXTERNAL_PUBLIC const casadi_int *EXTERNAL_JACOBIAN_CALLED(_sparsity_out)(casadi_int i)
{
    return i ? NULL : external_jacobian;
}

EXTERNAL_PUBLIC int EXTERNAL_JACOBIAN_CALLED(_work)(casadi_int *sz_arg, casadi_int *sz_res, casadi_int *sz_iw,
                                                    casadi_int *sz_w)
{
    *sz_arg = 2;
    *sz_res = 1;
    *sz_iw = 0;
    *sz_w = EXTERNAL_N + EXTERNAL_N * EXTERNAL_P;
    return 0;
}

EXTERNAL_PUBLIC int EXTERNAL_JACOBIAN_CALLED(_checkout)(void)
{
    return external_take();
}

EXTERNAL_PUBLIC void EXTERNAL_JACOBIAN_CALLED(_release)(int which)
{
    external_let_go(which);
}

EXTERNAL_PUBLIC void EXTERNAL_JACOBIAN_CALLED(_incref)(void)
{
    external_begin();
}

EXTERNAL_PUBLIC void EXTERNAL_JACOBIAN_CALLED(_decref)(void)
{
    external_end();
}
