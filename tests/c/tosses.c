/* Tosses of a model by every method and law, under the sanitizers: what reads or writes beside its arrays, overflows or leaks ends the
 * program. Of every run the state is taken out in the middle and put into another simulation, which has to reach the same end.
 * MODEL is the model's package, VALUES its header as Model.write_header writes it. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include VALUES

#define JOINED(a, b) a##b
#define OF(package, name) JOINED(package, name)

enum { N = OF(MODEL, _n) };
static const double UNTIL = 2.0;
static unsigned long long drawn = 1;

/* A number from -1 to 1 (Knuth's generator MMIX) */
static double draw(void)
{
    drawn = drawn * 6364136223846793005ULL + 1442695040888963407ULL;
    return (double)(drawn >> 11) * 0x1p-52 - 1.0;
}

/* Until the simulation has got somewhere, or cannot go on: the code, and how many events there were. A budget that is spent, and
 * friction that jams, are ends like others. */
static int fly(struct ccgen_simulation *simulation, double until, int *events)
{
    struct ccgen_event event;
    int code;
    for (*events = 0; !(code = ccgen_step_to_event(simulation, until, &event)) && event.kind != CCGEN_NO_EVENT;
         ++*events)
        if (*events == 300)
            return 0;
    return code;
}

static int toss(const char *method, const char *law, const double *q, const double *u)
{
    struct ccgen_settings settings = OF(MODEL, _settings);
    settings.method = method;
    settings.law = law;
    settings.rtol = 1e-7;
    settings.rate_budget = 2000;
    struct ccgen_simulation *one, *other;
    int events, codes[2], counts[2], wrong = 0;
    if (ccgen_create(&OF(ccgen_model_, MODEL), &settings, &one) ||
        ccgen_create(&OF(ccgen_model_, MODEL), &settings, &other))
        return 1;
    const size_t size = ccgen_state_size(one);
    char *state = malloc(size), *ends[2] = {malloc(size), malloc(size)};
    int code = ccgen_reset(one, 0.0, q, u);
    if (!code)
        code = fly(one, 0.3 * UNTIL, &events);
    if (!code && state && ends[0] && ends[1]) {
        ccgen_get_state(one, state);
        struct ccgen_simulation *both[] = {one, other};
        wrong |= ccgen_set_state(other, state);
        for (int i = 0; i < 2; i++) {
            codes[i] = fly(both[i], UNTIL, &counts[i]);
            ccgen_get_state(both[i], ends[i]);
        }
        if (!codes[0] && !codes[1]) /* budgets begin anew with a state, so that one may be spent and not the other */
            wrong |= counts[0] != counts[1] || memcmp(ends[0], ends[1], size);
        code = codes[0];
    }
    printf("%s %s: %s%s\n", method, law, ccgen_outcome_name(code), wrong ? ", NOT THE SAME" : "");
    free(state);
    free(ends[0]);
    free(ends[1]);
    ccgen_destroy(one);
    ccgen_destroy(other);
    return wrong;
}

int main(int count, char **arguments)
{
    static const char *const METHODS[] = {"gauss", "dop853", "dopri5", "radau"};
    static const char *const LAWS[] = {"newton", "poisson", "stronge"};
    const int tosses = count > 1 ? atoi(arguments[1]) : 12;
    int wrong = 0;
    for (int i = 0; i < tosses; i++) {
        double u[N];
        for (int k = 0; k < N; k++)
            u[k] = OF(MODEL, _u)[k] + 2.0 * draw();
        wrong |= toss(METHODS[i % 4], LAWS[i / 4 % 3], OF(MODEL, _q), u);
    }
    return wrong;
}
