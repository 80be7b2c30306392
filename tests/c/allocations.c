/* Tosses of a model by every method and law, with what they ask for memory counted: linked with --wrap of malloc, calloc, realloc and free.
 * Between the making of a simulation and its end only its record may grow, by realloc; a toss that is made again has room for that too.
 * Prints how many contacts were struck at once at most, how often rows were dependent, and how contacts were held.
 * MODEL is the model's package, VALUES its header as Model.write_header writes it. */
#include <stdio.h>

#include VALUES

#include "interface/simulation.h"

#define JOINED(a, b) a##b
#define OF(package, name) JOINED(package, name)

enum { N = OF(MODEL, _n), TOSSES = 12 };
static const double UNTIL = 2.0;
static unsigned long long drawn = 1;
static long asked, grown; /* calls of malloc, calloc and free; of realloc */

void *__real_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);
void *__real_realloc(void *memory, size_t size);
void __real_free(void *memory);

void *__wrap_malloc(size_t size)
{
    asked++;
    return __real_malloc(size);
}

void *__wrap_calloc(size_t count, size_t size)
{
    asked++;
    return __real_calloc(count, size);
}

void *__wrap_realloc(void *memory, size_t size)
{
    grown++;
    return __real_realloc(memory, size);
}

void __wrap_free(void *memory)
{
    asked++;
    __real_free(memory);
}

/* A number from -1 to 1 (Knuth's generator MMIX) */
static double draw(void)
{
    drawn = drawn * 6364136223846793005ULL + 1442695040888963407ULL;
    return (double)(drawn >> 11) * 0x1p-52 - 1.0;
}

/* What tosses have met, all together */
static struct {
    size_t most, stuck, slid;
    long dependent;
} met;

static void fly(struct ccgen_simulation *it)
{
    struct ccgen_event event;
    for (int events = 0; events < 600; events++)
        if (ccgen_step_to_event(it, UNTIL, &event) || event.kind == CCGEN_NO_EVENT)
            break;
    const struct impacts *impacts = &it->run.impacts;
    const struct mode_history *modes = &it->run.modes;
    for (size_t i = 0; i < impacts->count; i++)
        if (impacts->first[i + 1] - impacts->first[i] > met.most)
            met.most = impacts->first[i + 1] - impacts->first[i];
    for (size_t i = 0; i < modes->contact_count; i++) {
        met.stuck += modes->mode[i] == STICK;
        met.slid += modes->mode[i] == SLIP_FORWARD || modes->mode[i] == SLIP_BACKWARD;
    }
    met.dependent += it->system.rank_deficient;
}

/* Toss twice: whether memory was asked for */
static int toss(const struct ccgen_settings *settings, const double *q, const double *u)
{
    struct ccgen_simulation *it;
    int wrong = 0;
    if (ccgen_create(&OF(ccgen_model_, MODEL), settings, &it))
        return 1;
    asked = grown = 0;
    for (int time = 0; time < 2; time++) {
        const long before = grown;
        const int code = ccgen_reset(it, 0.0, q, u);
        if (!code)
            fly(it);
        if (asked || (time && grown > before)) {
            printf("%s %s asked %ld times, and %ld for its record\n", settings->method, settings->law, asked,
                   grown - before);
            wrong = 1;
        }
    }
    ccgen_destroy(it);
    return wrong;
}

int main(void)
{
    static const char *const METHODS[] = {"gauss", "dop853", "dopri5", "radau"};
    static const char *const LAWS[] = {"newton", "poisson", "stronge"};
    int wrong = 0;
    for (int i = 0; i < TOSSES; i++) {
        struct ccgen_settings settings = OF(MODEL, _settings);
        double u[N];
        settings.method = METHODS[i % 4];
        settings.law = LAWS[i / 4 % 3];
        settings.rtol = 1e-7;
        settings.rate_budget = 4000;
        settings.drift = i == 5 ? 2 : 0;
        settings.acceleration_scale = i % 6 == 4 ? 100.0 : 0.0; /* refined */
        for (int k = 0; k < N; k++)
            u[k] = OF(MODEL, _u)[k] +
                   (i < 4 ? 0.0 : 2.0 * draw()); /* the first ones as they are: all that may strike at once */
        wrong |= toss(&settings, OF(MODEL, _q), u);
    }
    printf("struck at once %zu, dependent %ld, stuck %zu, slid %zu\n", met.most, met.dependent, met.stuck, met.slid);
    return wrong;
}
