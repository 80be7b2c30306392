/* The Jacobian of the accelerations along a run, from the generated derivatives, against differences of the accelerations that the
 * same contacts are held in, of eighth order. Prints a line per state at which it is looked: how contacts are held, whether the Jacobian
 * is known, the largest entry, and by how much at most the two differ.
 * MODEL is the model's package, VALUES its header as Model.write_header writes it; the arguments are the time until which it runs and the step of the
 * differences. */
#include <stdio.h>

#include VALUES

#include "interface/simulation.h"
#include "motion/acceleration.h"
#include "motion/jacobian.h"

#define JOINED(a, b) a##b
#define OF(package, name) JOINED(package, name)

enum { N = OF(MODEL, _n), PARTS = 60, POINTS = 4 };
/* weights of f(x + k h) - f(x - k h), k = 1 to 4, in h f'(x) */
static const double WEIGHT[POINTS] = {4.0 / 5.0, -1.0 / 5.0, 4.0 / 105.0, -1.0 / 280.0};
static double step = 0x1p-9; /* rad, m, rad/s or m/s */

/* by[N][2 N] by differences; 0, or 1 where there are no accelerations */
static int differentiate(struct system *s, double t, const double *state, double by[N][2 * N])
{
    for (int c = 0; c < 2 * N; c++) {
        for (int i = 0; i < N; i++)
            by[i][c] = 0.0;
        for (int k = -POINTS; k <= POINTS; k++) {
            double moved[2 * N], u_dot[N];
            if (!k)
                continue;
            memcpy(moved, state, sizeof moved);
            moved[c] += k * step;
            if (system_acceleration(s, t, moved, moved + N, u_dot, NULL))
                return 1;
            for (int i = 0; i < N; i++)
                by[i][c] += (k > 0 ? WEIGHT[k - 1] : -WEIGHT[-k - 1]) * u_dot[i] / step;
        }
    }
    return 0;
}

static int look(struct ccgen_simulation *it)
{
    static double by_q[N * N], by_u[N * N], wanted[N][2 * N];
    double t, state[2 * N], most = 0.0, wrong = 0.0;
    int known;
    ccgen_get_motion(it, &t, state, state + N);
    if (acceleration_jacobian(&it->system, t, state, state + N, by_q, by_u, &known))
        return 1;
    if (known && differentiate(&it->system, t, state, wanted))
        return 1;
    for (int i = 0; i < N && known; i++)
        for (int j = 0; j < 2 * N; j++) {
            const double found = j < N ? by_q[i * N + j] : by_u[i * N + j - N];
            most = fmax(most, fabs(wanted[i][j]));
            wrong = fmax(wrong, fabs(found - wanted[i][j]));
        }
    printf("%d %.3g %.3g", known, most, wrong);
    for (int i = 0; i < it->phase.active.count; i++)
        printf(";%s", ccgen_mode_name(it->phase.active.mode[i]));
    printf("\n");
    return 0;
}

int main(int count, char **words)
{
    struct ccgen_settings settings = OF(MODEL, _settings);
    struct ccgen_simulation *it;
    struct ccgen_event event;
    const double until = count > 1 ? atof(words[1]) : 1.0;
    if (count > 2)
        step = atof(words[2]);
    settings.method = "radau";
    settings.rtol = 1e-8;
    if (ccgen_create(&OF(ccgen_model_, MODEL), &settings, &it) || ccgen_reset(it, 0.0, OF(MODEL, _q), OF(MODEL, _u)))
        return 1;
    for (int part = 0; part <= PARTS; part++) {
        do {
            if (part && ccgen_step_to_event(it, until * part / PARTS, &event))
                return 1;
            if (look(it))
                return 1;
        } while (part && event.kind != CCGEN_NO_EVENT);
    }
    ccgen_destroy(it);
    return 0;
}
