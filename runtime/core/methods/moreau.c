/* Time stepping from start to end: no smooth steps and no events, but steps of fixed length that have both (hybrid/time_stepping.c). */
#include "methods/method.h"

static size_t no_scratch(const struct system *s)
{
    (void)s;
    return 0;
}

/* A method of order 0 takes no smooth steps. */
const struct method moreau = {.name = "moreau", .scratch = no_scratch};
