/* The memory of an arena: pieces in a chain, each at least twice as large as the one before it was when it was added. */
#include "base/arena.h"

enum { LEAST = 4096 }; /* bytes of a piece */

struct chunk {
    struct chunk *next;
    size_t size;
    char bytes[];
};

int reserve(struct arena *arena, size_t bytes)
{
    struct chunk *present = arena->top.chunk, **link = present ? &present->next : &arena->first, *next = *link;
    if (!next || next->size < bytes) {
        const size_t twice = present ? 2 * present->size : LEAST, size = bytes > twice ? bytes : twice;
        if (size > SIZE_MAX - sizeof *next || !(next = malloc(sizeof *next + size)))
            return 1;
        CCGEN_FORBID(next->bytes, size);
        next->next = *link; /* one that is too small now may do later */
        next->size = size;
        *link = next;
    }
    arena->top = (struct mark){next, next->bytes, next->bytes + next->size};
    return 0;
}

void *take_elsewhere(struct arena *arena, size_t size, size_t alignment, size_t count)
{
    const size_t beside = alignment + CCGEN_APART + size;
    if (count > (SIZE_MAX - beside) / size || reserve(arena, count * size + beside)) {
        arena->ran_out = arena->has_run_out = 1;
        return NULL;
    }
    return take_array(arena, size, alignment, count);
}

void free_arena(struct arena *arena)
{
    for (struct chunk *chunk = arena->first, *next; chunk; chunk = next) {
        next = chunk->next;
        CCGEN_ALLOW(chunk->bytes, chunk->size);
        free(chunk);
    }
    *arena = (struct arena){0};
}

#ifdef CCGEN_SANITIZED
void forbid_from(struct arena *arena, struct mark mark)
{
    for (struct chunk *chunk = mark.chunk ? mark.chunk : arena->first; chunk; chunk = chunk->next) {
        char *from = chunk == mark.chunk ? mark.at : chunk->bytes;
        CCGEN_FORBID(from, (size_t)((chunk == arena->top.chunk ? arena->top.at : chunk->bytes + chunk->size) - from));
        if (chunk == arena->top.chunk)
            return;
    }
}
#endif
