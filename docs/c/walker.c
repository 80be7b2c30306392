/* The simplest walker from C: it walks down a slope, and the ground below the foot that swings is off while the legs pass each other. The scene's
 * events switch it; the core does that. docs/c.md has the commands that compile it. */
#include <stdio.h>
#include <stdlib.h>

#include "simplest_walker.h"

static const double UNTIL = 12.0;
static const char *const EVENTS[] = {"right_through", "right_ahead", "left_through",
                                     "left_ahead"}; /* as in the scene */

static void check(int code, const char *what)
{
    if (!code)
        return;
    fprintf(stderr, "%s: %s\n", what, ccgen_outcome_name(code));
    exit(1);
}

int main(void)
{
    struct ccgen_settings settings = simplest_walker_settings;
    struct ccgen_simulation *walker;
    struct ccgen_event event;
    double q[simplest_walker_n], u[simplest_walker_n];

    settings.events = CCGEN_ACT;
    check(ccgen_create(&ccgen_model_simplest_walker, &settings, &walker), "create");
    check(ccgen_reset(walker, 0.0, simplest_walker_q, simplest_walker_u), "reset");
    do {
        check(ccgen_step_to_event(walker, UNTIL, &event), "step_to_event");
        ccgen_get_motion(walker, NULL, q, u);
        if (event.kind == CCGEN_CROSSES)
            printf("t = %12.9f s  %s\n", event.t, EVENTS[event.indicator]);
        else if (event.kind == CCGEN_CLOSES && event.impacts)
            printf("t = %12.9f s  a foot strikes\n", event.t);
    } while (event.kind != CCGEN_NO_EVENT && event.kind != CCGEN_ENDS);
    ccgen_destroy(walker);
    return 0;
}
