/* Configurations of a branch of the closure in its chart, where rows count well enough to tell them; see chart.c. */
#ifndef CCGEN_CHART_H
#define CCGEN_CHART_H

#include "model/system.h"

enum { BRANCH_NODES = 16 };

/* A configuration of the branch, and how near to dependence rows are there */
struct branch_place {
    double *y, *q, *T; /* [freedom] in the chart, [n] in units of the coordinates, [freedom][n] dq/dy */
    double margin;
    int turn;
};

/* What lies where rows depend: unknown, a crossing of two branches, or a place that motions pass by, on a branch that comes near to it */
enum at_place { UNDECIDED, CROSSES, PASSES_BY };

/* The branch as a graph over its tangents at one place: y = T0 (q - q0), with q in units of the coordinates. */
struct branch {
    int rank;                   /* rows that count beside places where fewer do, 0 as long as that is not known, */
    int freedom;                /* and n less that */
    double *chart;              /* [freedom][n] T0, orthonormal */
    struct branch_place begins; /* where the chart begins, */
    struct branch_place known;  /* and whence to go on: from there, or where all rows count well */
    struct branch_place nodes[BRANCH_NODES];
    double *node_bias;        /* [BRANCH_NODES][n] accelerations there, in units, at the rate 1 of a single freedom, */
    int biased;               /* if they are known */
    int sampled;              /* whether the nodes lie on a ray through the place */
    double *ray, *middle;     /* [freedom] its direction, and where it meets the place */
    double half, slope;       /* half of its length, and the distance from dependence by the way along it */
    double width;             /* distance from dependence of the outermost nodes that served last, or 0 */
    int referenced;           /* whether nodes are closed as one configuration is, */
    double *reference;        /* [n] which: that at which the ray meets the place */
    enum at_place kind;       /* what there is near the chart */
    int placed;               /* whether the motion passes by a place that is known, */
    double *place;            /* [n] where it lies, */
    int alone;                /* the row that is lost at a crossing by itself, while others nearly are; -1 */
    double *offset;           /* [rows] and what the closure misses there, if that is more than rounding */
    double *heading;          /* [n] velocities that told a branch last; zeros: none have */
    double *through;          /* [freedom] the direction in which a motion goes through it, */
    double until, comes_back; /* the way there, and how fast rows come back along it: 0 where it does not */
    struct branch_place last; /* the configuration that was asked for last; */
    int inside;               /* whether it is interpolated, */
    double weights[BRANCH_NODES]; /* and by what */
    double *state;                /* [2 n] the state that was put onto the branch last */
};

/* the longest way in the chart whose end is found at once */
static const double HOP = 0.06;

/* The closure at a configuration, its rows that are on factorised as columns */
struct closed {
    double *g, *length, *diagonal, *beta, *right; /* [rows][n], [rows]: lengths and right-hand sides of all rows */
    int *order;                                   /* [rows on] the row of each column */
    double *q;                                    /* [n] the configuration */
    double *null;                                 /* [freedom][n] directions that rows leave */
    double *across, *pivots, *reflected; /* [freedom][freedom] T0 of them, its rows factorised as columns, [freedom] */
    int *places, regular;                /* [freedom]; whether all of them count */
    double *z, *solved;                  /* [freedom] */
    double margin;
    int turn; /* sign of the determinant of rows and chart: another than where the chart begins beyond a turn of the branch; 0 where rows are redundant, and do not tell */
};

int take_place(struct arena *arena, size_t n, struct branch_place *p);

void copy_place(const struct system *s, const struct branch *b, const struct branch_place *from,
                struct branch_place *to);

int take_closed(const struct system *s, const struct branch *b, struct closed *c);

/* Factorise the rows that are on at c->q; how many are no nearer to the others than `nearest`. With last >= 0 that row is factorised after all others, and `nearest` is 0. */
int reduce_rows(struct system *s, double nearest, int last, struct closed *c);

/* Column `number` of the orthogonal factor, of the first `rank` rows */
void column_of_factor(int n, int rank, const struct closed *c, int number, double *x);

/* The closure at q[n] in units, with T0; NOT_CLOSED where too few rows count. */
enum outcome factorise_closure(struct system *s, const struct branch *b, const double *q, struct closed *c);

/* gap[rows] of the closure at c->q, as the place of the branch tells them */
enum outcome write_gaps(struct system *s, const struct branch *b, const struct closed *c, double *gap);

/* x[n] with A x = c->right on the rows that count and T0 x = y[freedom], in units; whether there is one */
int solve_in_chart(const struct system *s, const struct branch *b, struct closed *c, const double *y, double *x);

/* The place at p->y, by Newton's iteration from p->q: that, its tangents, and how near rows are there; the closure as it is factorised in c. */
enum outcome close_at(struct system *s, const struct branch *b, struct closed *c, struct branch_place *p);

/* to->q as the tangents at `from` have it, at to->y */
void predict(int n, int d, const struct branch_place *from, struct branch_place *to);

/* The place at p->y + way[freedom], from p on, in pieces; p is moved there. */
enum outcome go_along(struct system *s, const struct branch *b, struct closed *c, struct branch_place *p,
                      const double *way);

/* How near to dependence rows of the closure are, 0 where fewer than `rank` count; those of driven joints do not. -1 when memory runs out */
double closure_margin(struct system *s, const double *q, int rank);

#endif
