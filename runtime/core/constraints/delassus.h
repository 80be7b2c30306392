/* The Delassus operator: rates of contacts that their impulses give. */
#ifndef CCGEN_DELASSUS_H
#define CCGEN_DELASSUS_H

#include "constraints/active_set.h"

/* Rates of the contacts `set` that unit impulses along their normals give, and if the model is rough, along their tangents
 * below them: columns[k][n], W[k][k] with k = count or 2 count, symmetric */
enum outcome delassus(struct system *s, const double *q, int count, const int *set, double *columns, double *W);

/* Let contacts give way to their impulses: by a part `compliance` of what their own move there. */
void give_way(int rows, double compliance, double *W);

#endif
