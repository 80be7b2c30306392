/* Sums of products. */
#ifndef CCGEN_DOT_H
#define CCGEN_DOT_H

#include <stddef.h>

static inline double dot(int n, const double *a, const double *b)
{
    double sum = 0.0;
    for (int i = 0; i < n; i++)
        sum += a[i] * b[i];
    return sum;
}

/* sums[count] of the products of a[n] with each of the vectors b, `stride` apart, or of each with itself where a is NULL. Four are
 * summed at a time: the terms of one wait for each other, those of different ones do not, and each sum is what dot() gives. */
static inline void dots(int n, int count, size_t stride, const double *a, const double *b, double *sums)
{
    int j = 0;
    for (; j + 4 <= count; j += 4) {
        const double *b0 = b + j * stride, *b1 = b0 + stride, *b2 = b1 + stride, *b3 = b2 + stride;
        double s0 = 0.0, s1 = 0.0, s2 = 0.0, s3 = 0.0;
        for (int i = 0; i < n; i++) {
            s0 += (a ? a[i] : b0[i]) * b0[i];
            s1 += (a ? a[i] : b1[i]) * b1[i];
            s2 += (a ? a[i] : b2[i]) * b2[i];
            s3 += (a ? a[i] : b3[i]) * b3[i];
        }
        sums[j] = s0;
        sums[j + 1] = s1;
        sums[j + 2] = s2;
        sums[j + 3] = s3;
    }
    for (; j < count; j++)
        sums[j] = dot(n, a ? a : b + j * stride, b + j * stride);
}

#endif
