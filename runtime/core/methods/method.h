/* The protocol behind which every integration method stands. One file per method; `all_methods.h` lists them. */
#ifndef CCGEN_METHOD_H
#define CCGEN_METHOD_H

#include "methods/all_methods.h"
#include "model/system.h"

/* What a step may be wrong by. An entry of a state has a scale of its own: `unit` of the system. */
struct tolerance {
    double rtol, atol; /* atol: times the entry's unit */
    const double *unit;
    int places; /* the first so many entries, */
    double
        nearer; /* of which this part may be wrong: beside a place that a branch passes by, they tell where it turns */
};

/* What entry i, of this size, may be wrong by */
static inline double allowed_error(struct tolerance tolerance, int i, double size)
{
    const double allowed = tolerance.atol * tolerance.unit[i] + tolerance.rtol * size;
    return i < tolerance.places ? tolerance.nearer * allowed : allowed;
}

/* Nothing may be wrong but by rounding. */
static inline struct tolerance to_rounding(const struct system *s)
{
    return (struct tolerance){.unit = s->unit};
}

struct method {
    const char *name;
    int order; /* of the solution that is carried on */
    int damps; /* whether it damps what stages have wrong across the closure, so that its estimate does not show it */
    int derivatives; /* whether every step, and not only the first after a restart, needs dy at its start */
    /* numbers of scratch that a method needs, zeros at first; the same scratch goes to all its calls */
    size_t (*scratch)(const struct system *s);
    /* the next step does not go on where the last one ended; NULL where that makes no difference */
    void (*restart)(double *scratch, int size);
    /* What the next step takes over from the last, as numbers: copied out of the scratch, or if `put` back into it; how many
     * they are. NULL where a step knows of none before. Without `numbers` only their count is wanted. */
    size_t (*memory)(const struct system *s, double *scratch, int put, double *numbers);
    /* one step of length h from (t, y) with dy = derivative there: y1, and estimates of its error left in the scratch. A
     * method that iterates does so to a small part of the tolerance, or, where it is zero, until rounding ends it. */
    enum outcome (*step)(struct system *s, double *scratch, double t, double h, struct tolerance tolerance,
                         const double *y, const double *dy, double *y1);
    /* the step's estimates, `count` arrays one after another; who knows better may change them before they are measured. NULL, as
     * `measure`, of a method that has none: then no tolerance chooses its steps, and runs by it have a fixed one. */
    double *(*estimates)(double *scratch, int size, int *count);
    /* what the estimates amount to; accepted up to 1 */
    double (*measure)(const double *scratch, int size, struct tolerance tolerance, const double *y, const double *y1);
    /* prepare interpolation over the step just taken, whose end has become (y1, dy1) */
    enum outcome (*prepare)(struct system *s, double *scratch, double t, double h, const double *y, const double *dy,
                            const double *y1, const double *dy1);
    /* the state at t + theta h, 0 <= theta <= 1, into y */
    void (*interpolate)(const double *scratch, int size, double theta, double *y);
};

/* the method called `name`, or NULL */
const struct method *find_method(const char *name);

/* whether a method estimates its errors, so that a tolerance can choose its steps */
int estimates_errors(const struct method *method);

/* how many numbers a method takes over from step to step */
static inline size_t memory_size(const struct method *method, const struct system *s)
{
    return method->memory ? method->memory(s, NULL, 0, NULL) : 0;
}

/* the methods themselves, for those that hand steps over to another */
#define DECLARED(name) extern const struct method name;
ALL_METHODS(DECLARED)
#undef DECLARED

/* all methods, NULL at the end */
extern const struct method *const all_methods[];

#endif
