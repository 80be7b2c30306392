/* The last of what a run does beside steps that are accepted: how its stages follow each other, which steps it refuses and why, where effects come to another side. It decides nothing. */
#include "record/trace.h"

void trace(struct trace *trace, struct traced one)
{
    if (!trace->of)
        return;
    trace->of[trace->count++ % TRACED_MOST] = one;
    trace->highest = trace->highest > trace->count ? trace->highest : trace->count;
}

/* The first that no later one has been written over, also one that was taken back */
static size_t first_kept(const struct trace *trace)
{
    return trace->highest > TRACED_MOST ? trace->highest - TRACED_MOST : 0;
}

size_t kept_traced(const struct trace *trace)
{
    const size_t first = first_kept(trace);
    return trace->count > first ? trace->count - first : 0;
}

struct traced traced_at(const struct trace *trace, size_t k)
{
    return trace->of[(first_kept(trace) + k) % TRACED_MOST];
}
