/* An arena by itself, under the sanitizers: arrays lie where their types may, do not overlap, keep their numbers while others are taken and
 * given back, and memory is allocated where there is none yet and nowhere else. */
#include <stdio.h>

#include "base/arena.h"

enum { ARRAYS = 40 };
typedef double lanes __attribute__((vector_size(4 * sizeof(double))));

static int wrong = 0;

static void check(int right, const char *what)
{
    if (!right)
        printf("%s\n", what);
    wrong |= !right;
}

static int aligned(const void *array, size_t alignment)
{
    return array && (uintptr_t)array % alignment == 0;
}

/* Arrays of several types in turn, each filled with its own number: whether all have kept theirs */
static void take_in_turn(struct arena *arena, size_t count)
{
    const struct mark mark = arena->top;
    unsigned char *arrays[ARRAYS];
    size_t sizes[ARRAYS];
    for (int i = 0; i < ARRAYS; i++) {
        const size_t some = count * (size_t)(i + 1);
        switch (i % 4) {
        case 0:
            arrays[i] = (unsigned char *)TAKE(arena, double, some);
            sizes[i] = some * sizeof(double);
            check(aligned(arrays[i], _Alignof(double)), "a number is not aligned");
            break;
        case 1:
            arrays[i] = (unsigned char *)TAKE(arena, char, some);
            sizes[i] = some;
            break;
        case 2:
            arrays[i] = (unsigned char *)TAKE_ZEROS(arena, lanes, some);
            sizes[i] = some * sizeof(lanes);
            check(aligned(arrays[i], _Alignof(lanes)), "a vector is not aligned");
            for (size_t k = 0; k < sizes[i]; k++)
                check(arrays[i][k] == 0, "zeros are none");
            break;
        default:
            arrays[i] = (unsigned char *)TAKE(arena, int, some);
            sizes[i] = some * sizeof(int);
            check(aligned(arrays[i], _Alignof(int)), "an int is not aligned");
        }
        memset(arrays[i], i + 1, sizes[i]);
    }
    check(!arena->ran_out, "memory has run out");
    for (int i = 0; i < ARRAYS; i++)
        for (size_t k = 0; k < sizes[i]; k++)
            check(arrays[i][k] == i + 1, "an array has not kept its numbers");
    give_back(arena, mark);
}

int main(void)
{
    struct arena arena = {0};
    check(TAKE(&arena, double, 0) != NULL, "an array of nothing is no array");
    check(!reserve(&arena, 1 << 20), "nothing is reserved");
    const char *const end = arena.top.end;
    double *kept = TAKE(&arena, double, 3);
    kept[0] = kept[1] = kept[2] = 7.0;
    take_in_turn(&arena, 10);
    check(arena.top.end == end, "what was reserved is not what is taken from");
    for (size_t count = 1; count < 3000; count *= 3)
        take_in_turn(&arena, count);
    check(arena.top.end == end && kept[0] == 7.0 && kept[2] == 7.0, "what is below a mark has changed");
    const struct mark mark = arena.top;
    double *huge = TAKE(&arena, double, SIZE_MAX / 2);
    check(!huge && arena.ran_out, "more than there can be was taken");
    check(TAKE(&arena, double, 5) && arena.ran_out, "that memory has run out is forgotten");
    give_back(&arena, mark);
    check(!arena.ran_out && arena.top.at == mark.at, "what was given back is not taken again");
    free_arena(&arena);
    check(!arena.first && !arena.top.at, "the arena is not empty");
    free_arena(&arena);
    return wrong;
}
