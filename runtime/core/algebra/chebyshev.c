/* Interpolation at the Chebyshev points: the barycentric formula. */
#include "algebra/chebyshev.h"

#include <math.h>

static double angle(int count, int i)
{
    return (2 * i + 1) * acos(0.0) / count;
}

double chebyshev_point(int count, int i)
{
    return cos(angle(count, i));
}

void chebyshev_weights(int count, double x, double *weight)
{
    double sum = 0.0;
    for (int i = 0; i < count; i++) {
        const double point = chebyshev_point(count, i);
        if (x == point) {
            for (int j = 0; j < count; j++)
                weight[j] = j == i;
            return;
        }
        weight[i] = (i % 2 ? -1.0 : 1.0) * sin(angle(count, i)) / (x - point);
        sum += weight[i];
    }
    for (int i = 0; i < count; i++)
        weight[i] /= sum;
}

void chebyshev_coefficient(int count, int k, double *weight)
{
    for (int i = 0; i < count; i++)
        weight[i] = (k ? 2.0 : 1.0) / count * cos(k * angle(count, i));
}
