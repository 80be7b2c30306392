/* Whether numbers from outside are in order: asked of every state, hence in vectors where the machine has some. */
#include "core.h"

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
 * for comparisons not all of them. Two sums do not wait for each other. */
int all_within(size_t n, const double *x, double limit)
{
    const size_t whole = n - n % (2 * PACK);
    const double scale = DBL_MAX / limit;
    pack even = {0.0}, odd = {0.0};
    for (size_t i = 0; i < whole; i += 2 * PACK) {
        even += 0.0 * (scale * *(const stored *)(x + i));
        odd += 0.0 * (scale * *(const stored *)(x + i + PACK));
    }
    const pack both = even + odd;
    double sum = 0.0;
    for (size_t i = 0; i < PACK; i++)
        sum += ENTRY(both, i);
    for (size_t i = whole; i < n; i++)
        sum += 0.0 * (scale * x[i]);
    return sum == 0.0;
}

int all_finite(size_t n, const double *x)
{
    return all_within(n, x, DBL_MAX);
}
