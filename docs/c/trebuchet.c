/* A trebuchet from C: its pouch lets go of the stone where the sling has swung round, and the stone flies until it strikes the ground. The core finds when
 * the joint lets go, and goes on without it. docs/c.md has the commands that compile it. */
#include <stdio.h>
#include <stdlib.h>

#include "trebuchet.h"

enum { STONE = 3, LINKS = 5 }; /* as in the header */
static const double UNTIL = 20.0;

static void check(int code, const char *what)
{
    if (!code)
        return;
    fprintf(stderr, "%s: %s\n", what, ccgen_outcome_name(code));
    exit(1);
}

/* Where the stone is: x, y (m) */
static void find_stone(const struct ccgen_simulation *trebuchet, double *place)
{
    double q[trebuchet_n], poses[LINKS][3];
    ccgen_get_motion(trebuchet, NULL, q, NULL);
    ccgen_model_trebuchet.poses(ccgen_get_constants(trebuchet), q, poses[0]);
    place[0] = poses[STONE][0];
    place[1] = poses[STONE][1];
}

int main(void)
{
    struct ccgen_settings settings = trebuchet_settings;
    struct ccgen_simulation *trebuchet;
    struct ccgen_event event;
    double place[2];
    int thrown = 0, landed = 0;

    settings.events = CCGEN_ACT;
    check(ccgen_create(&ccgen_model_trebuchet, &settings, &trebuchet), "create");
    check(ccgen_reset(trebuchet, 0.0, trebuchet_q, trebuchet_u), "reset");
    do {
        check(ccgen_step_to_event(trebuchet, UNTIL, &event), "step_to_event");
        find_stone(trebuchet, place);
        if (event.kind == CCGEN_CROSSES)
            printf("thrown at t = %.9f s from x = %.9f m, y = %.9f m\n", event.t, place[0], place[1]);
        thrown |= event.kind == CCGEN_CROSSES;
        landed = thrown && event.impacts;
    } while (!landed && event.kind != CCGEN_NO_EVENT);
    printf("lands at t = %.9f s at x = %.9f m\n", event.t, place[0]);
    ccgen_destroy(trebuchet);
    return 0;
}
