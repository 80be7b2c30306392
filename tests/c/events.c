/* The search for events on known motions, and their location and a run's bounces on a ball above the ground: no mechanism. */
#include "interface/simulation.h"
#include "steps/event_location.h"
#include "steps/event_search.h"

/* -- known motions: gap i at theta is a polynomial and a cosine, and so is its rate ------------------------------------- */

enum { TERMS = 7, WAVE = 3, WIDTH = TERMS + WAVE }; /* coefficients; height, frequency and phase of the cosine */

static void known_motion(const double *table, int size, double theta, double *y)
{
    const int n = size / 2;
    for (int i = 0; i < n; i++) {
        const double *c = table + i * WIDTH, *wave = c + TERMS;
        double value = 0.0, rate = 0.0;
        for (int j = TERMS - 1; j >= 0; j--) {
            rate = rate * theta + value;
            value = value * theta + c[j];
        }
        y[i] = value + wave[0] * cos(wave[1] * theta + wave[2]);
        y[n + i] = rate - wave[0] * wave[1] * sin(wave[1] * theta + wave[2]);
    }
}

/* The first number of `k` is the number of gaps, the second how fast the second link turns. */
static void known_gaps(const double *k, const double *q, double *out)
{
    memcpy(out, q, (size_t)k[0] * sizeof *out);
}

static void known_rates(const double *k, const double *q, const double *u, double *out)
{
    (void)q;
    memcpy(out, u, (size_t)k[0] * sizeof *out);
}

static void known_velocities(const double *k, const double *q, const double *u, double *out)
{
    (void)q;
    (void)u;
    memset(out, 0, 6 * sizeof *out);
    out[5] = k[1];
}

/* The contact of the first event of gaps with the motions table[contacts][WIDTH] in a step of length 1, or -1, and where */
int first_event(int contacts, const double *table, double turning, double slow, double *theta)
{
    const struct ccgen_model model = {.nq = contacts,
                                      .nu = contacts,
                                      .links = 2,
                                      .contacts = contacts,
                                      .gaps = known_gaps,
                                      .gap_rates = known_rates,
                                      .velocities = known_velocities};
    const struct method method = {.name = "known", .interpolate = known_motion};
    const double k[2] = {contacts, turning};
    struct arena arena = {0};
    double *extent = TAKE(&arena, double, contacts);
    for (int c = 0; c < contacts; c++)
        extent[c] = 1.0;
    struct system s = {.model = &model, .k = k, .n = contacts, .size = 2 * contacts, .extent = extent, .length = 1.0};
    s.time = 1.0;
    s.arena = &arena;
    struct event found = {-1, 2.0, CLOSES, 1.0};
    const enum outcome outcome = find_event(&s, &method, table, 0.0, 1.0, slow, 1, &found);
    *theta = found.theta;
    free_arena(&arena);
    return outcome ? -2 : found.contact;
}

/* -- a ball: one coordinate, its height above the ground; parameters mass, gravity and restitution ----------------------- */

enum { MASS, GRAVITY, RESTITUTION, PARAMETERS };

static void ball_constants(const double *p, double *k)
{
    memcpy(k, p, PARAMETERS * sizeof *k);
}

static int ball_acceleration(const double *k, const double *q, const double *u, double t, const double *inputs,
                             double *u_dot, double *lambda)
{
    (void)q, (void)u, (void)t, (void)inputs, (void)lambda;
    u_dot[0] = -k[GRAVITY];
    return 0;
}

/* in one lane, as the sums over stages below */
static unsigned ball_lane(const double *k, const double *q, const double *u, const double *t, const double *inputs,
                          double *u_dot, double *lambda)
{
    return (unsigned)ball_acceleration(k, q, u, *t, inputs, u_dot, lambda);
}

static void one_lane_stages(int n, int stages, const double *base, const double *slope, const double *node,
                            const double *matrix, const double *x, double *out)
{
    for (int i = 0; i < n; i++) {
        out[i] = base[i] + slope[i] * node[0];
        for (int j = 0; j < stages; j++)
            out[i] += x[i * stages + j] * matrix[j];
    }
}

static int ball_impulse(const double *k, const double *q, const double *f, const double *y, double *du, double *lambda)
{
    (void)q, (void)y, (void)lambda;
    du[0] = f[0] / k[MASS];
    return 0;
}

static int ball_response(const double *k, const double *q, int count, const double *P, double *du, double *rates)
{
    (void)q;
    for (int i = 0; i < count; i++)
        du[i] = rates[i] = P[i] / k[MASS];
    return 0;
}

static void ball_momentum(const double *k, const double *q, const double *u, double *out)
{
    (void)q;
    out[0] = k[MASS] * u[0];
}

static void ball_inverse(const double *k, const double *q, const double *u, double t, const double *inputs,
                         const double *u_dot, double *f)
{
    (void)q, (void)u, (void)t, (void)inputs;
    f[0] = k[MASS] * (u_dot[0] + k[GRAVITY]);
}

static void ball_energy(const double *k, const double *q, const double *u, double *out)
{
    out[0] = 0.5 * k[MASS] * u[0] * u[0];
    out[1] = k[MASS] * k[GRAVITY] * q[0];
}

static void ball_poses(const double *k, const double *q, double *out)
{
    (void)k;
    out[0] = out[2] = 0.0;
    out[1] = q[0];
}

static void ball_velocities(const double *k, const double *q, const double *u, double *out)
{
    (void)k, (void)q;
    out[0] = out[2] = 0.0;
    out[1] = u[0];
}

static void ball_gap(const double *k, const double *q, double *out)
{
    (void)k;
    out[0] = q[0];
}

static void ball_rate(const double *k, const double *q, const double *u, double *out)
{
    (void)k, (void)q;
    out[0] = u[0];
}

static void ball_bias(const double *k, const double *q, const double *u, double *out)
{
    (void)k, (void)q, (void)u;
    out[0] = 0.0;
}

static void ball_push(const double *k, const double *q, const double *P, double *f)
{
    (void)k, (void)q;
    f[0] = P[0];
}

static void ball_restitution(const double *k, double *e)
{
    e[0] = k[RESTITUTION];
}

static const struct ccgen_model ball = {.version = CCGEN_CONTRACT_VERSION,
                                        .name = "ball",
                                        .hash = "ball",
                                        .nq = 1,
                                        .nu = 1,
                                        .base = 1,
                                        .links = 1,
                                        .contacts = 1,
                                        .parameters = PARAMETERS,
                                        .constants = PARAMETERS,
                                        .lanes = 1,
                                        .derive_constants = ball_constants,
                                        .acceleration = ball_acceleration,
                                        .acceleration_lanes = ball_lane,
                                        .stages = one_lane_stages,
                                        .impulse = ball_impulse,
                                        .contact_response = ball_response,
                                        .momentum = ball_momentum,
                                        .inverse_dynamics = ball_inverse,
                                        .energy = ball_energy,
                                        .poses = ball_poses,
                                        .velocities = ball_velocities,
                                        .gaps = ball_gap,
                                        .gap_rates = ball_rate,
                                        .gap_bias = ball_bias,
                                        .contact_impulse = ball_push,
                                        .restitution = ball_restitution};

static struct ccgen_simulation *ball_at(const char *method, const double *parameters, double t, double height,
                                        double speed)
{
    const struct ccgen_settings settings = {.parameters = parameters, .method = method, .rtol = 1e-12};
    struct ccgen_simulation *it;
    if (ccgen_create(&ball, &settings, &it))
        return NULL;
    if (ccgen_reset(it, t, &height, &speed)) {
        ccgen_destroy(it);
        return NULL;
    }
    return it;
}

/* Land on the event that the search takes to be at `theta` of a step: its outcome; the part of the step until then, and height
 * and speed there */
int locate_ball(const char *method, const double *parameters, double t, double height, double speed, double step,
                double theta, double *length, double *y)
{
    struct ccgen_simulation *it = ball_at(method, parameters, t, height, speed);
    if (!it)
        return -1;
    struct phase *f = &it->phase;
    enum outcome outcome = evaluate_derivative(f);
    f->h = step;
    if (!outcome)
        outcome = locate_event(f, (struct event){0, theta, CLOSES, 1.0});
    *length = f->h;
    memcpy(y, f->y1, 2 * sizeof *y);
    ccgen_destroy(it);
    return outcome;
}

/* Times of the first `count` events of a ball, as the public functions tell them; how many there were before `until` */
int bounces(const char *method, const double *parameters, double t, double height, double speed, double until,
            int count, double *times)
{
    struct ccgen_simulation *it = ball_at(method, parameters, t, height, speed);
    int found = 0;
    for (struct ccgen_event event; it && found < count; found++) {
        if (ccgen_step_to_event(it, until, &event) || event.kind == CCGEN_NO_EVENT)
            break;
        times[found] = event.t;
    }
    ccgen_destroy(it);
    return found;
}
