/* Nodes of a branch on both sides of dependent rows, and what lies between them; see ray.c. */
#ifndef CCGEN_RAY_H
#define CCGEN_RAY_H

#include "constraints/chart.h"

/* The last configuration is that at y, at part x, -1 to 1, of the ray. */
void interpolate(const struct system *s, struct branch *b, const double *y, double x);

/* The configuration at y by nodes across the place near it, or, where it lies beside them, from the nearest */
enum outcome bridge(struct system *s, struct branch *b, struct closed *c, const double *y);

/* Where y lies along the ray of the nodes */
double along_ray(const struct branch *b, const double *y);

#endif
