/* The hybrid state as bytes; see state.h. */
#include "hybrid/state.h"

#include <string.h>

#include "model/scales.h"

enum way { COUNT, GET, PUT };

/* What a state is of: it fits where these are the same. */
struct kind {
    uint64_t sum; /* of all bytes behind it in a state that is sealed, else 0 */
    char magic[8];
    int version, number; /* of this layout; bytes of a number */
    int size, contacts;
    char method[16], hash[80];
};

static struct kind kind_of(const struct phase *f)
{
    struct kind kind;
    memset(&kind, 0, sizeof kind);
    memcpy(kind.magic, "ccgen\n", 6);
    kind.version = 6;
    kind.number = (int)sizeof(double);
    kind.size = f->s->size;
    kind.contacts = f->s->model->contacts;
    strncpy(kind.method, f->run->method->name, sizeof kind.method - 1);
    strncpy(kind.hash, f->s->model->hash, sizeof kind.hash - 1);
    return kind;
}

/* All parts of the state but what the method remembers, one after another; their bytes. */
static size_t walk(struct automaton *a, struct phase *f, enum way way, char *bytes)
{
    const size_t c = f->s->model->contacts, number = sizeof *f->y;
    struct run *run = f->run;
    struct progress *at = &f->at;
    struct active_set *h = &f->active;
    const struct {
        void *part;
        size_t size;
    } parts[] = {{&f->t, number},
                 {f->y, f->s->size * number},
                 {f->dy, f->s->size * number},
                 {&f->h, number},
                 {&at->under_way, sizeof at->under_way},
                 {&at->crawled, sizeof at->crawled},
                 {&at->crawls_since, number},
                 {&at->since, number},
                 {&at->next, number},
                 {&at->late, number},
                 {&at->energy_known, sizeof at->energy_known},
                 {&at->bounded, sizeof at->bounded},
                 {at->energy, sizeof at->energy},
                 {at->energy_end, sizeof at->energy_end},
                 {&at->energy_h, number},
                 {&at->energy_in_motion, number},
                 {&at->stretch, number},
                 {&at->stretch_end, number},
                 {&at->place, number},
                 {&at->own, number},
                 {&at->passage, sizeof at->passage},
                 {&at->gap_uncertainty, number},
                 {&at->flat, number},
                 {&at->slow, number},
                 {&f->s->time, number},
                 {&f->s->energy, number},
                 {&run->steps, sizeof run->steps},
                 {&run->rejected, sizeof run->rejected},
                 {&run->events, sizeof run->events},
                 {&run->choices, sizeof run->choices},
                 {&run->window, number},
                 {&run->spent_before, sizeof run->spent_before},
                 {&run->rest_speed, number},
                 {&h->count, sizeof h->count},
                 {&h->rows, sizeof h->rows},
                 {&h->implied, sizeof h->implied},
                 {&h->window, number},
                 {h->set, c * sizeof *h->set},
                 {h->of, 2 * c * sizeof *h->of},
                 {h->mode, c * sizeof *h->mode},
                 {h->closed, c * sizeof *h->closed},
                 {h->force, 2 * c * number},
                 {h->weight, 2 * c * number},
                 {h->least, c * number},
                 {h->peak, c * number},
                 {f->met, c * sizeof *f->met},
                 {f->sides, f->s->model->switches * number},
                 {f->latched, f->s->model->latches * number},
                 {&a->stage, sizeof a->stage},
                 {&a->event.contact, sizeof a->event.contact},
                 {&a->event.watch, sizeof a->event.watch},
                 {&a->event.theta, number},
                 {&a->event.behind, number},
                 {&a->loss.contact, sizeof a->loss.contact},
                 {&a->loss.how, sizeof a->loss.how},
                 {&a->crowds, sizeof a->crowds},
                 {&a->struck, sizeof a->struck},
                 {&a->idle, sizeof a->idle},
                 {&a->events, sizeof a->events},
                 {&a->still, sizeof a->still},
                 {&a->window, number},
                 {&a->earlier, sizeof a->earlier},
                 {&a->crowd, sizeof a->crowd},
                 {&a->jammed, number},
                 {&a->span.length, number},
                 {&a->span.ends, number},
                 {&a->span.step, number},
                 {&a->span.scale, number},
                 {&a->span.under_way, sizeof a->span.under_way},
                 {&a->instant, number},
                 {&a->at_once, sizeof a->at_once}};
    size_t size = 0;
    for (size_t i = 0; i < sizeof parts / sizeof *parts; size += parts[i++].size) {
        if (way == GET && parts[i].size)
            memcpy(bytes + size, parts[i].part, parts[i].size);
        if (way == PUT && parts[i].size)
            memcpy(parts[i].part, bytes + size, parts[i].size);
    }
    return size;
}

/* Whether whole numbers of a state, by which arrays are read, are what they may be */
static int is_sound(const struct automaton *a, const struct phase *f)
{
    const struct active_set *h = &f->active;
    const int c = f->s->model->contacts;
    int wrong = a->stage >= STAGES_OF_RUN || f->at.passage > ABOUT || h->count < 0 || h->count > c ||
                h->rows < h->count || h->rows > 2 * h->count || h->implied < 0 || h->implied > c ||
                a->event.contact < -1 || a->event.contact >= c || a->event.watch < JAMS || a->loss.contact < -1 ||
                a->loss.contact >= c || a->events < 0 || f->run->steps < 0;
    for (int i = 0; i < h->count && !wrong; i++)
        wrong = h->set[i] < 0 || h->set[i] >= c || h->mode[i] < AT_LIMIT_BACKWARD || h->mode[i] > OPEN;
    for (int i = 0; i < h->rows && !wrong; i++)
        wrong = h->of[i] < 0 || h->of[i] >= h->count;
    for (int i = 0; i < c && !wrong; i++)
        wrong = h->closed[i] < WATCHED || h->closed[i] > CARRIED;
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

size_t state_size(const struct phase *f)
{
    struct automaton none;
    struct phase copy = *f;
    const size_t remembered = memory_size(f->run->method, f->s) * sizeof *f->y;
    return sizeof(struct kind) + walk(&none, &copy, COUNT, NULL) + remembered;
}

void get_state(const struct automaton *a, const struct phase *f, void *bytes)
{
    const struct kind kind = kind_of(f);
    const size_t remembered = memory_size(f->run->method, f->s) * sizeof *f->y;
    char *at = bytes;
    memcpy(at, &kind, sizeof kind);
    at += sizeof kind;
    at += walk((struct automaton *)a, (struct phase *)f, GET, at); /* it changes nothing */
    if (remembered) {
        f->run->method->memory(f->s, f->scratch, 0, f->kept);
        memcpy(at, f->kept, remembered);
    }
}

int set_state(struct automaton *a, struct phase *f, const void *bytes)
{
    const struct kind kind = kind_of(f);
    const size_t remembered = memory_size(f->run->method, f->s) * sizeof *f->y;
    const size_t sum = sizeof kind.sum;
    if (memcmp((const char *)bytes + sum, (const char *)&kind + sum, sizeof kind - sum))
        return 1;
    const char *at = (const char *)bytes + sizeof kind;
    at += walk(a, f, PUT, (char *)at); /* it changes nothing there */
    set_units(f->s);
    if (remembered) {
        memcpy(f->kept, at, remembered);
        f->run->method->memory(f->s, f->scratch, 1, f->kept);
    }
    return is_sound(a, f) ? 0 : 2;
}
