/* What events and joints have changed along a run, with the values of all parameters behind each: the run is one of several models, one behind the other, and who reads
 * its record has to know which is in force where. */
#include "interface/changes.h"

#include <stdlib.h>
#include <string.h>

static int make_room(struct changes *c, size_t parameters)
{
    const size_t room = c->room ? 2 * c->room : 8;
    struct ccgen_change *of = realloc(c->of, room * sizeof *of);
    c->of = of ? of : c->of;
    struct origin *origin = realloc(c->origin, room * sizeof *origin);
    c->origin = origin ? origin : c->origin;
    double *values = realloc(c->values, (room * parameters + 1) * sizeof *values);
    c->values = values ? values : c->values;
    if (!of || !origin || !values)
        return 1;
    c->room = room;
    return 0;
}

struct ccgen_change *try_change(struct ccgen_simulation *it, int indicator, int gate)
{
    struct changes *c = &it->changes;
    const size_t parameters = it->system.model->parameters;
    if (c->tried == c->room && make_room(c, parameters))
        return NULL;
    const size_t k = c->tried++;
    c->of[k] = (struct ccgen_change){.t = it->phase.t, .indicator = indicator, .gate = gate, .crossing = it->crossing};
    c->origin[k] = (struct origin){.impact = it->run.impacts.count};
    if (parameters)
        memcpy(c->values + k * parameters, it->run.values, parameters * sizeof *c->values);
    return &c->of[k];
}

void keep_changes(struct ccgen_simulation *it, struct recorded at)
{
    struct changes *c = &it->changes;
    for (; c->count < c->tried; c->count++) {
        c->of[c->count].row = at.rows;
        c->origin[c->count].at = at;
        c->origin[c->count].time = it->system.time;
        c->origin[c->count].energy = it->system.energy;
    }
}

void cut_changes(struct ccgen_simulation *it, size_t row)
{
    struct changes *c = &it->changes;
    while (c->count && c->origin[c->count - 1].at.rows >= row)
        c->count--;
    c->tried = c->count;
}

void forget_changes(struct ccgen_simulation *it)
{
    it->changes.count = it->changes.tried = 0;
}

void free_changes(struct ccgen_simulation *it)
{
    free(it->changes.of);
    free(it->changes.origin);
    free(it->changes.values);
}

int ccgen_changes(const struct ccgen_simulation *it, size_t *count, const struct ccgen_change **changes,
                  const double **parameters)
{
    *count = it->changes.count;
    *changes = *count ? it->changes.of : NULL;
    *parameters = *count ? it->changes.values : NULL;
    return it->run.acts ? OUTCOME_DONE : OUTCOME_BAD_SETTINGS;
}
