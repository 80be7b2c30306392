/* What a run does beside steps that are accepted: the last of it; see trace.c. */
#ifndef CCGEN_TRACE_H
#define CCGEN_TRACE_H

#include <stddef.h>

#include "base/outcome.h"
#include "base/real.h"

enum traced_kind {
    TRACED_STAGE, /* the automaton goes from one stage to another, `of` -> `to`, by an event of `contact`, or by a failure, `outcome` */
    TRACED_REFUSAL, /* a step of the length h is refused: by its `error`, times what may be, or by a failure */
    TRACED_KINK     /* an effect comes to the other side of the kink `of` */
};

struct traced {
    double t, h, error;
    int kind, of, to, contact, watch, outcome;
};

enum { TRACED_MOST = 512 /* kept, the last: of what led to an end, the stretch that a person reads */ };

struct trace {
    struct traced *of;     /* [TRACED_MOST], a ring, or NULL: nothing is kept */
    size_t count, highest; /* how many there are, and have been before some were taken back */
};

void trace(struct trace *trace, struct traced one);

/* How many of the last are kept, and the k-th of these */
size_t kept_traced(const struct trace *trace);
struct traced traced_at(const struct trace *trace, size_t k);

#endif
