/* Whether numbers from outside are in order: asked of every state, hence in vectors where the machine has some. */
#include "base/within.h"

#if CCGEN_PRECISION == 2
typedef double pack;
typedef double stored;
#define PACK 1
#define ENTRY(x, i) (x)
#else
typedef double pack __attribute__((vector_size(16)));
typedef double stored __attribute__((vector_size(16), aligned(sizeof(double)), may_alias));
#define PACK (sizeof(pack) / sizeof(double))
#define ENTRY(x, i) (x)[i]
#endif

/* Sums of zeros, unless a number is not finite or is infinite when it is scaled: compilers have vectors for these products,
 * for comparisons not all of them. Four sums do not wait for each other. */
int all_within(size_t n, const double *x, double limit)
{
    const size_t whole = n - n % (4 * PACK);
    const double scale = DBL_MAX / limit;
    pack a = {0.0}, b = a, c = a, d = a;
    for (const double *next = x; next < x + whole; next += 4 * PACK) {
        const stored *four = (const stored *)next;
        a += 0.0 * (scale * four[0]);
        b += 0.0 * (scale * four[1]);
        c += 0.0 * (scale * four[2]);
        d += 0.0 * (scale * four[3]);
    }
    const pack all = (a + b) + (c + d);
    double sum = 0.0;
    for (size_t i = 0; i < PACK; i++)
        sum += ENTRY(all, i);
    for (size_t i = whole; i < n; i++)
        sum += 0.0 * (scale * x[i]);
    return sum == 0.0;
}

int all_finite(size_t n, const double *x)
{
    return all_within(n, x, DBL_MAX);
}
