/* Whether a run is to end, asked about everywhere that work is done, so that the answer comes in time whatever a step costs. */
#include "base/interruption.h"

static const int64_t BETWEEN = 20000000; /* ns between two questions: a person sees no delay, a run none either */
enum { BETWEEN_LOOKS = 1000 }; /* accelerations of freedoms worked out between two looks at the clock: microseconds */

static int64_t now(void)
{
    struct timespec time;
    timespec_get(&time, TIME_UTC);
    return (int64_t)time.tv_sec * 1000000000 + time.tv_nsec;
}

void start_asking(struct interruption *i, double t)
{
    i->t = t;
    i->asked = i->at_once ? 0 : now();
    i->work = 0;
    i->ended = 0;
}

int ask(struct interruption *i)
{
    if (!i->ended && i->tick)
        i->ended = i->tick(i->context, i->t) != 0;
    i->asked = i->at_once ? 0 : now();
    i->work = 0;
    return i->ended;
}

int interrupted(struct interruption *i, long work)
{
    if (!i || i->ended)
        return i && i->ended;
    i->work += work;
    if (work && i->work < BETWEEN_LOOKS)
        return 0;
    i->work = 0;
    if (i->at_once)
        return ask(i);
    const int64_t since = now() - i->asked;
    return since >= 0 && since < BETWEEN ? 0 : ask(i);
}
