/* Tosses of a model whose simulations have less and less memory, under the sanitizers: wherever it runs out the code says so, or the motion goes
 * on without what it was for, and afterwards the simulation does what it does with enough of it. Linked with --wrap of malloc.
 * MODEL is the model's package, VALUES its header as Model.write_header writes it. */
#include <stdio.h>

#include VALUES

#include "interface/simulation.h"

#define JOINED(a, b) a##b
#define OF(package, name) JOINED(package, name)

static const double UNTIL = 1.0;
static int refuses; /* whether malloc does */

void *__real_malloc(size_t size);

void *__wrap_malloc(size_t size)
{
    return refuses ? NULL : __real_malloc(size);
}

static int fly(struct ccgen_simulation *it)
{
    struct ccgen_event event;
    int code = ccgen_reset(it, 0.0, OF(MODEL, _q), OF(MODEL, _u));
    for (int events = 0; !code && events < 12; events++)
        if ((code = ccgen_step_to_event(it, UNTIL, &event)) || event.kind == CCGEN_NO_EVENT)
            break;
    return code;
}

int main(void)
{
    struct ccgen_settings settings = OF(MODEL, _settings);
    struct ccgen_simulation *it;
    settings.rtol = 1e-7;
    settings.law = "poisson";
    if (ccgen_create(&OF(ccgen_model_, MODEL), &settings, &it))
        return 1;
    const size_t size = ccgen_state_size(it);
    char *usual = malloc(size), *found = malloc(size);
    if (!usual || !found || fly(it))
        return 1;
    ccgen_get_state(it, usual);
    const struct mark top = it->arena.top;
    int starved = 0, wrong = 0;
    for (size_t bytes = 0; top.at + bytes < top.end; bytes += 64 + bytes / 32) {
        it->arena.top.end = top.at + bytes;
        refuses = 1;
        const int code = fly(it);
        refuses = 0;
        starved += code == OUTCOME_NO_MEMORY;
        wrong |= it->arena.top.at != top.at; /* all is given back */
    }
    it->arena.top = top;
    wrong |= fly(it);
    ccgen_get_state(it, found);
    wrong |= memcmp(usual, found, size) != 0;
    printf("starved %d\n", starved);
    free(usual);
    free(found);
    ccgen_destroy(it);
    return wrong || starved < 5;
}
