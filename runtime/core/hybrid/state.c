/* The hybrid state as bytes; see state.h. */
#include "hybrid/state.h"

#include <string.h>

#include "model/scales.h"

/* What a state is of: it fits where these are the same. */
struct kind {
    uint64_t sum; /* of all bytes behind it in a state that is sealed, else 0 */
    char magic[8];
    int version, number; /* of this layout; bytes of a number */
    int size, contacts, acts;
    char method[16], hash[80];
};

static struct kind kind_of(const struct phase *f)
{
    struct kind kind;
    memset(&kind, 0, sizeof kind);
    memcpy(kind.magic, "ccgen\n", 6);
    kind.version = 22;
    kind.number = (int)sizeof(double);
    kind.size = f->s->size;
    kind.contacts = f->s->model->contacts;
    kind.acts = f->run->acts;
    strncpy(kind.method, f->run->method->name, sizeof kind.method - 1);
    strncpy(kind.hash, f->s->model->hash, sizeof kind.hash - 1);
    return kind;
}

/* All parts of the state but what the method remembers, one after another: numbers, and arrays with their lengths. The preprocessor puts in
 * what is done with each, so that to copy a number is a move and no call: the state is copied before every stage, and short runs feel it. */
#define ALL_PARTS(NUMBER, ARRAY)                                \
    NUMBER(f->t)                                                \
    ARRAY(f->y, f->s->size)                                     \
    ARRAY(f->dy, f->s->size)                                    \
    NUMBER(f->h)                                                \
    NUMBER(at->under_way)                                       \
    NUMBER(at->crawled)                                         \
    NUMBER(at->crawls_since)                                    \
    NUMBER(at->since)                                           \
    NUMBER(at->next)                                            \
    NUMBER(at->late)                                            \
    NUMBER(at->energy_known)                                    \
    NUMBER(at->bounded)                                         \
    NUMBER(at->longest)                                         \
    NUMBER(at->refused)                                         \
    NUMBER(at->energy)                                          \
    NUMBER(at->energy_end)                                      \
    NUMBER(at->energy_h)                                        \
    NUMBER(at->energy_in_motion)                                \
    NUMBER(at->meets)                                           \
    NUMBER(at->stretch)                                         \
    NUMBER(at->stretch_end)                                     \
    NUMBER(f->branch.rank)                                      \
    NUMBER(f->branch.placed)                                    \
    ARRAY(f->branch.place, f->s->n)                             \
    ARRAY(f->branch.heading, f->s->n)                           \
    ARRAY(f->branch.offset, f->s->model->rows)                  \
    NUMBER(at->widest)                                          \
    NUMBER(at->follows)                                         \
    NUMBER(at->seen)                                            \
    NUMBER(at->slow)                                            \
    NUMBER(f->s->time)                                          \
    NUMBER(f->s->energy)                                        \
    NUMBER(run->steps)                                          \
    NUMBER(run->rejected)                                       \
    NUMBER(run->events)                                         \
    NUMBER(run->window)                                         \
    NUMBER(run->spent_before)                                   \
    NUMBER(run->rest_speed)                                     \
    NUMBER(h->count)                                            \
    NUMBER(h->rows)                                             \
    NUMBER(h->implied)                                          \
    NUMBER(h->window)                                           \
    ARRAY(h->set, c)                                            \
    ARRAY(h->of, 2 * c)                                         \
    ARRAY(h->mode, c)                                           \
    ARRAY(h->closed, c)                                         \
    ARRAY(h->twin, c)                                           \
    ARRAY(h->force, 2 * c)                                      \
    ARRAY(h->least, c)                                          \
    ARRAY(h->peak, c)                                           \
    ARRAY(f->met, c)                                            \
    ARRAY(f->tight, c)                                          \
    ARRAY(f->sides, f->s->model->switches)                      \
    ARRAY(f->latched, f->s->model->latches)                     \
    ARRAY(run->values, run->acts ? f->s->model->parameters : 0) \
    NUMBER(a->stage)                                            \
    NUMBER(a->event.contact)                                    \
    NUMBER(a->event.watch)                                      \
    NUMBER(a->event.theta)                                      \
    NUMBER(a->event.behind)                                     \
    NUMBER(a->loss.contact)                                     \
    NUMBER(a->loss.how)                                         \
    NUMBER(a->crowds)                                           \
    NUMBER(a->struck)                                           \
    NUMBER(a->idle)                                             \
    NUMBER(a->events)                                           \
    NUMBER(a->still)                                            \
    NUMBER(a->window)                                           \
    NUMBER(a->quick)                                            \
    NUMBER(a->earlier)                                          \
    NUMBER(a->crowd)                                            \
    NUMBER(a->jammed)                                           \
    NUMBER(a->span.length)                                      \
    NUMBER(a->span.begins)                                      \
    NUMBER(a->span.ends)                                        \
    NUMBER(a->span.step)                                        \
    NUMBER(a->span.scale)                                       \
    NUMBER(a->span.under_way)                                   \
    NUMBER(a->failed)                                           \
    NUMBER(a->at_fault)                                         \
    NUMBER(a->instant)                                          \
    NUMBER(a->at_once)

static size_t size_of_parts(const struct automaton *a, const struct phase *f)
{
#define NUMBER(part) size += sizeof(part);
#define ARRAY(part, count) size += (count) * sizeof *(part);
    const struct run *run = f->run;
    const struct progress *at = &f->at;
    const struct active_set *h = &f->active;
    const size_t c = f->s->model->contacts;
    size_t size = 0;
    (void)a;
    ALL_PARTS(NUMBER, ARRAY)
    return size;
#undef NUMBER
#undef ARRAY
}

static void copy_bytes(void *to, const void *from, size_t size)
{
    if (size) /* arrays of no numbers may be nowhere */
        memcpy(to, from, size);
}

/* Copy the parts out; where the next byte goes. */
static char *get_parts(const struct automaton *a, const struct phase *f, char *to)
{
#define NUMBER(part) copy_bytes(to, &(part), sizeof(part)), to += sizeof(part);
#define ARRAY(part, count) copy_bytes(to, part, (count) * sizeof *(part)), to += (count) * sizeof *(part);
    const struct run *run = f->run;
    const struct progress *at = &f->at;
    const struct active_set *h = &f->active;
    const size_t c = f->s->model->contacts;
    ALL_PARTS(NUMBER, ARRAY)
    return to;
#undef NUMBER
#undef ARRAY
}

/* Take them from there; where the next byte is. */
static const char *put_parts(struct automaton *a, struct phase *f, const char *from)
{
#define NUMBER(part) copy_bytes(&(part), from, sizeof(part)), from += sizeof(part);
#define ARRAY(part, count) copy_bytes(part, from, (count) * sizeof *(part)), from += (count) * sizeof *(part);
    struct run *run = f->run;
    struct progress *at = &f->at;
    struct active_set *h = &f->active;
    const size_t c = f->s->model->contacts;
    ALL_PARTS(NUMBER, ARRAY)
    return from;
#undef NUMBER
#undef ARRAY
}

/* Whether whole numbers of a state, by which arrays are read, are what they may be */
static int is_sound(const struct automaton *a, const struct phase *f)
{
    const struct active_set *h = &f->active;
    const int c = f->s->model->contacts;
    int wrong = a->stage >= STAGES_OF_RUN || f->branch.rank < 0 || f->branch.rank > f->s->n ||
                f->branch.rank > f->s->model->rows || f->branch.placed < 0 ||
                f->branch.placed > (f->branch.chart != NULL) || h->count < 0 || h->count > c || h->rows < h->count ||
                h->rows > 2 * h->count || h->implied < 0 || h->implied > c || a->event.contact < -1 ||
                a->event.contact >= c || a->event.watch < JAMS || a->loss.contact < -1 || a->loss.contact >= c ||
                a->events < 0 || f->run->steps < 0;
    for (int i = 0; i < h->count && !wrong; i++)
        wrong = h->set[i] < 0 || h->set[i] >= c || h->mode[i] < AT_LIMIT_BACKWARD || h->mode[i] > OPEN;
    for (int i = 0; i < h->rows && !wrong; i++)
        wrong = h->of[i] < 0 || h->of[i] >= h->count;
    for (int i = 0; i < c && !wrong; i++)
        wrong = h->closed[i] < WATCHED || h->closed[i] > CARRIED || h->twin[i] < -1 || h->twin[i] >= c;
    return !wrong && (a->stage != MEET || a->event.watch < switching_count(f->s));
}

/* The sum of a state's bytes but its own, which damage changes: as FNV-1a, of words and with a shift. Several sums in turn, of which
 * none waits for another: short runs feel it. */
static uint64_t sum_of(const char *bytes, size_t size)
{
    enum { SUMS = 4 };
    const uint64_t basis = 14695981039346656037u, prime = 1099511628211u;
    uint64_t sums[SUMS] = {basis, basis, basis, basis}, sum = basis;
    size_t at = sizeof sum;
    for (; at + sizeof sums <= size; at += sizeof sums) {
        uint64_t words[SUMS];
        memcpy(words, bytes + at, sizeof words);
        for (int i = 0; i < SUMS; i++) {
            sums[i] = (sums[i] ^ words[i]) * prime;
            sums[i] ^= sums[i] >> 32; /* products carry upwards only: two signs would cancel */
        }
    }
    for (; at < size; at++)
        sum = (sum ^ (unsigned char)bytes[at]) * prime;
    for (int i = 0; i < SUMS; i++) {
        sum = (sum ^ sums[i]) * prime;
        sum ^= sum >> 32;
    }
    return sum;
}

void seal_state(void *bytes, size_t size)
{
    const uint64_t sum = sum_of(bytes, size);
    memcpy(bytes, &sum, sizeof sum);
}

int is_whole(const void *bytes, size_t size)
{
    const uint64_t sum = sum_of(bytes, size);
    return !memcmp(bytes, &sum, sizeof sum);
}

size_t kept_size(const struct phase *f)
{
    return size_of_parts(NULL, f) + memory_size(f->run->method, f->s) * sizeof *f->y;
}

void keep_state(const struct automaton *a, const struct phase *f, void *bytes)
{
    const size_t remembered = memory_size(f->run->method, f->s) * sizeof *f->y;
    char *at = get_parts(a, f, bytes);
    if (remembered) {
        f->run->method->memory(f->s, f->scratch, 0, f->kept);
        memcpy(at, f->kept, remembered);
    }
}

void take_back(struct automaton *a, struct phase *f, const void *bytes)
{
    const size_t remembered = memory_size(f->run->method, f->s) * sizeof *f->y;
    const char *at = put_parts(a, f, bytes);
    set_units(f->s);
    f->s->branch = NULL; /* a step that follows one begins it */
    if (remembered) {
        memcpy(f->kept, at, remembered);
        f->run->method->memory(f->s, f->scratch, 1, f->kept);
    }
}

size_t state_size(const struct phase *f)
{
    return sizeof(struct kind) + kept_size(f);
}

void get_state(const struct automaton *a, const struct phase *f, void *bytes)
{
    const struct kind kind = kind_of(f);
    memcpy(bytes, &kind, sizeof kind);
    keep_state(a, f, (char *)bytes + sizeof kind);
}

int set_state(struct automaton *a, struct phase *f, const void *bytes)
{
    const struct kind kind = kind_of(f);
    const size_t sum = sizeof kind.sum;
    if (memcmp((const char *)bytes + sum, (const char *)&kind + sum, sizeof kind - sum))
        return 1;
    take_back(a, f, (const char *)bytes + sizeof kind);
    if (f->branch.rank > f->s->rows_on) /* from where more rows were on: it is found anew */
        f->branch.rank = 0;
    return is_sound(a, f) ? 0 : 2;
}
