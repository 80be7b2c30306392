/* An arena: memory as a stack. A function takes its arrays from it one by one, each with its own type and count, and gives all of
 * them back at its end:
 *
 *     const struct mark mark = arena->top;
 *     double *a = TAKE(arena, double, n * n), *x = TAKE_ZEROS(arena, double, n);
 *     int *order = TAKE(arena, int, n);
 *     if (arena->ran_out) ...
 *     ...
 *     give_back(arena, mark);
 *
 * What is given back stays with the arena and is taken again: memory is allocated only where more is taken at one time than
 * ever before, or than was reserved. An arena is for one thread at a time.
 */
#ifndef CCGEN_ARENA_H
#define CCGEN_ARENA_H

#include "base/real.h"

#if defined(__has_feature)
#if __has_feature(address_sanitizer)
#define CCGEN_SANITIZED
#endif
#elif defined(__SANITIZE_ADDRESS__)
#define CCGEN_SANITIZED
#endif

/* Under the address sanitizer only what is taken may be touched, and arrays lie apart. */
#ifdef CCGEN_SANITIZED
#include <sanitizer/asan_interface.h>
#define CCGEN_FORBID(from, bytes) __asan_poison_memory_region((void *)(uintptr_t)(from), bytes)
#define CCGEN_ALLOW(from, bytes) __asan_unpoison_memory_region(from, bytes)
#define CCGEN_APART ((size_t)32)
#define CCGEN_LEAST_ALIGNMENT ((size_t)8)
#else
#define CCGEN_FORBID(from, bytes) ((void)0)
#define CCGEN_ALLOW(from, bytes) ((void)0)
#define CCGEN_APART ((size_t)0)
#define CCGEN_LEAST_ALIGNMENT ((size_t)1)
#endif

struct chunk;

/* How far the arena is taken: what lies between `at` and `end` is free. */
struct mark {
    struct chunk *chunk;
    char *at, *end;
};

/* One that has nothing yet is all zeros. */
struct arena {
    struct mark top;
    int ran_out;         /* whether memory for some array was not there, since something was last given back */
    int has_run_out;     /* the same, until whoever asks sets it back: what lies between need not pass it on */
    struct chunk *first; /* all memory of the arena, in the order in which it is taken */
};

/* Have so many bytes in one piece before anything more is allocated; 0, or 1 when memory runs out. */
int reserve(struct arena *arena, size_t bytes);

/* Give the memory itself back; the arena may be used anew. */
void free_arena(struct arena *arena);

/* Take where the present piece has no room for it; NULL, and arena->ran_out is set, when memory runs out. */
void *take_elsewhere(struct arena *arena, size_t size, size_t alignment, size_t count);

static inline void *take_array(struct arena *arena, size_t size, size_t alignment, size_t count)
{
    struct mark *top = &arena->top;
    alignment = alignment > CCGEN_LEAST_ALIGNMENT ? alignment : CCGEN_LEAST_ALIGNMENT;
    const size_t skipped = CCGEN_APART + (size_t)(-((uintptr_t)top->at + CCGEN_APART) & (alignment - 1));
    const size_t left = (size_t)(top->end - top->at);
    /* no division, which takes long; and not all of the piece: no array begins where it ends */
    if (skipped >= left || count >= left || count * size >= left - skipped)
        return take_elsewhere(arena, size, alignment, count);
    char *array = top->at + skipped;
    top->at = array + count * size;
    CCGEN_ALLOW(array, count * size);
    return array;
}

static inline void *take_zeros(struct arena *arena, size_t size, size_t alignment, size_t count)
{
    void *array = take_array(arena, size, alignment, count);
    return array ? memset(array, 0, count * size) : NULL;
}

#define TAKE(arena, type, count) ((type *)take_array(arena, sizeof(type), _Alignof(type), count))
#define TAKE_ZEROS(arena, type, count) ((type *)take_zeros(arena, sizeof(type), _Alignof(type), count))

#ifdef CCGEN_SANITIZED
void forbid_from(struct arena *arena, struct mark mark);
#endif

/* Give back all that was taken since arena->top was `mark`. */
static inline void give_back(struct arena *arena, struct mark mark)
{
#ifdef CCGEN_SANITIZED
    forbid_from(arena, mark);
#endif
    arena->top = mark;
    arena->ran_out = 0;
}

#endif
