/* Small differences through a step, as all digits of what comes out: of several sizes, numbers of columns and arguments. The tableau is
 * that of no method, and what puts ends back that of no mechanism: the numbers are to be the same in vectors of any length. */
typedef long double widest; /* before the core says what a double is */

#include "motion/carried.h"

#include <stdio.h>

enum { MOST_SIZE = 9, ARGUMENTS = 2, MOST_COLUMNS = 17, WIDTH = 2 * MOST_SIZE + ARGUMENTS, ROWS = 2 };

static unsigned long state = 1;

static double number(void)
{
    state = (state * 1103515245ul + 12345ul) % 2147483648ul;
    return (double)state / 2147483648.0 - 0.5;
}

static void fill(double *x, size_t count, double size)
{
    for (size_t i = 0; i < count; i++)
        x[i] = size * number();
}

int main(void)
{
    static double J[NODES * MOST_SIZE * WIDTH], whole[WIDTH * MOST_COLUMNS], pull[MOST_SIZE * ROWS],
        moves[ROWS * WIDTH];
    double c[NODES], b[NODES], twice_b[NODES], A[NODES * NODES], twice[NODES * NODES];
    const struct collocation g = {c, b, twice_b, A, twice};
    fill(c, NODES, 1.0);
    fill(b, NODES, 1.0);
    fill(twice_b, NODES, 1.0);
    fill(A, NODES * NODES, 0.5);
    fill(twice, NODES * NODES, 0.5);
    for (int n = 1; n <= MOST_SIZE; n++)
        for (int columns = 1; columns <= MOST_COLUMNS; columns++) {
            struct carrying step = {.n = n, .width = 2 * n + columns % 2 * ARGUMENTS, .count = 1, .h = 0.3, .J = J};
            fill(J, (size_t)NODES * n * step.width, 1.0);
            for (int i = 0; i < NODES * n && n > 2; i++)
                J[i * step.width + n / 2] = J[i * step.width + n + n / 2] = 0.0; /* what feeds nothing back */
            fill(whole, (size_t)step.width * columns, 1.0);
            fill(pull, (size_t)n * ROWS, 0.1);
            fill(moves, (size_t)ROWS * step.width, 0.1);
            step.first[0] = n;
            step.rows[0] = ROWS;
            step.pull[0] = pull;
            step.moves[0] = moves;
            double *room = malloc(carry_room(&step, columns) * sizeof *room);
            if (!room || !carry(&g, &step, columns, whole, room))
                return 1;
            free(room);
            for (int i = 0; i < 2 * n * columns; i++)
                printf("%La\n", (widest)whole[i]);
        }
    return 0;
}
