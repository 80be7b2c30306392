/* The protocol behind which every law of impact stands. One file per law; `all_laws.h` lists them. */
#ifndef CCGEN_LAW_H
#define CCGEN_LAW_H

#include "impact/all_laws.h"
#include "impact/problem.h"

struct impact_law {
    const char *name;
    /* impulses total[2 count], zero at first, normals and then those of friction, and into k->rate the rates after them */
    enum outcome (*impulses)(struct impact_problem *k, double *total);
};

/* the law called `name`, or NULL */
const struct impact_law *find_law(const char *name);

#define DECLARED(name) extern const struct impact_law name;
ALL_LAWS(DECLARED)
#undef DECLARED

/* all laws, NULL at the end */
extern const struct impact_law *const all_laws[];

#endif
