/* The falling hexagon from C: event by event, and once more from a state that was taken out in the middle. docs/c.md has the
 * commands that compile it. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "falling_hexagon.h"

enum { N = falling_hexagon_n };
static const double UNTIL = 1.2;

/* Says what went wrong and ends the program; what has been computed so far was printed. */
static void check(int code, const char *what)
{
    if (!code)
        return;
    fprintf(stderr, "%s: %s\n", what, ccgen_outcome_name(code));
    exit(1);
}

static const char *const KINDS[] = {"end", "closes", "changes", "jams", "crosses", "ends"};

/* Go on to `until`, and tell each event on the way. */
static void fly(struct ccgen_simulation *simulation, double until)
{
    struct ccgen_event event;
    do {
        double q[N], u[N];
        check(ccgen_step_to_event(simulation, until, &event), "step_to_event");
        ccgen_get_motion(simulation, NULL, q, u);
        printf("%-8s t = %.12f s, contact %2d, impacts %zu, y_0 = %.12f m\n", KINDS[event.kind], event.t, event.contact,
               event.impacts, q[1]);
    } while (event.kind != CCGEN_NO_EVENT);
}

/* Energy (J), kinetic and potential: the model's own functions read its constants. */
static double energy(const struct ccgen_simulation *simulation)
{
    double q[N], u[N], parts[2];
    ccgen_get_motion(simulation, NULL, q, u);
    ccgen_model_falling_hexagon.energy(ccgen_get_constants(simulation), q, u, parts);
    return parts[0] + parts[1];
}

int main(void)
{
    struct ccgen_simulation *first, *second;
    struct ccgen_event event;

    check(ccgen_create(&ccgen_model_falling_hexagon, &falling_hexagon_settings, &first), "create");
    check(ccgen_create(&ccgen_model_falling_hexagon, &falling_hexagon_settings, &second), "create");
    check(ccgen_reset(first, 0.0, falling_hexagon_q, falling_hexagon_u), "reset");
    printf("energy %.9f J\n", energy(first));

    /* past the first three events; the state there is kept */
    for (int i = 0; i < 3; i++)
        check(ccgen_step_to_event(first, UNTIL, &event), "step_to_event");
    const size_t size = ccgen_state_size(first);
    void *state = malloc(size), *end = malloc(size), *other_end = malloc(size);
    if (!state || !end || !other_end)
        return 1;
    ccgen_get_state(first, state);
    printf("state    t = %.12f s, %zu bytes\n", event.t, size);

    fly(first, UNTIL);
    printf("energy %.9f J\n", energy(first));

    /* another simulation goes on from there, by the same bits */
    check(ccgen_set_state(second, state), "set_state");
    do
        check(ccgen_step_to_event(second, UNTIL, &event), "step_to_event");
    while (event.kind != CCGEN_NO_EVENT);
    ccgen_get_state(first, end);
    ccgen_get_state(second, other_end);
    printf("the same %s\n", memcmp(end, other_end, size) ? "no" : "yes");

    free(state);
    free(end);
    free(other_end);
    ccgen_destroy(first);
    ccgen_destroy(second);
    return 0;
}
