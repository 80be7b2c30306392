/* Where a branch of the closure crosses dependent rows; see crossing.c. */
#ifndef CCGEN_CROSSING_H
#define CCGEN_CROSSING_H

#include "constraints/chart.h"

enum { MOST_LOST = 8 };

/* What is about to be lost at a place: rows that come to cancel, and the directions that they alone still close */
struct lost {
    int count;
    double *W, *V; /* [count][rows] of the scaled rows, [count][n] */
    double *K;     /* [freedom + count][n] all directions that the other rows leave */
    double size;   /* of the first row */
};

/* A ray through the place: its direction e[freedom], where it meets dependence as seen from the known place, and the distance from dependence by its way */
struct crossing {
    double *e, place, slope;
};

/* l->W and l->K at the configuration that c is factorised at; their arrays from the arena. NO_MEMORY or DONE */
enum outcome find_lost(struct system *s, const struct branch *b, struct closed *c, struct lost *l);

/* row[count][n]: the rows that are about to be lost at q[n], in units */
enum outcome rows_of_lost(struct system *s, const struct lost *l, const double *q, double *row);

/* change[count][n]: by how much the rows that are about to be lost change along x[n] in units, per unit of it */
enum outcome change_of_lost(struct system *s, const struct lost *l, const double *q, const double *x, double *change);

/* Whether a row that is about to be lost closes at c->q, where gap[rows] of the closure are, but for the rounding of its terms */
int lost_row_closes(const struct system *s, const struct closed *c, const struct lost *l, int number,
                    const double *gap);

/* The ray at the known place; NOT_CLOSED where none crosses */
enum outcome find_crossing(struct system *s, const struct branch *b, struct closed *c, struct crossing *x);

#endif
