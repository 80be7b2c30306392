/* Steps past singular configurations; see singular_step.c. */
#ifndef CCGEN_SINGULAR_STEP_H
#define CCGEN_SINGULAR_STEP_H

#include "steps/step.h"

/* whether the step to end[2n], which was put back to y1 with the outcome `back`, passes a singular configuration, or ends
 * beside one, so that it is to be taken again: f->place is when */
int crosses_singularity(struct phase *f, enum outcome back, double error, const double *end);

/* whether collocation goes on taking the steps of a method that it has taken them over from; if not, the next is as long as those were */
int keeps_collocation(struct phase *f);

/* whether collocation takes over from the run's own method where the step begins, */
int begins_beside_singularity(struct phase *f);

/* or for where the step to y1 leads */
int leads_to_singularity(struct phase *f);

/* whether rows are so near to dependence at the end of the step that a branch is followed there */
int ends_near_dependence(struct phase *f);

/* a step by collocation in place of one of length f->h by the run's own method, which would take one of length `own` next */
void take_over(struct phase *f, double own);

/* the length of a step that may be as long as f->h, and how it is taken, from f->place: away from it as `elsewhere`, FREE or ABOUT */
void place_about_singularity(struct phase *f, enum passage elsewhere);

/* whether the step passes f->place, and one of length h in its stead would do so too */
int passes_place(const struct phase *f, double h);

/* the length of a step past f->place that is to be taken first where one is to end after `length`, which would have the place at a
 * stage; 0 where it may end there */
double clear_landing(const struct phase *f, double length);

/* whether a step of that length has f->place between two stages, as no longer one would */
int lies_clear(const struct phase *f, double length);

/* whether the singular configuration is passed elsewhere in the step to end[2n] than f->place says, which then says it better */
int misplaced(struct phase *f, const double *end);

/* how near to dependence rows are at q[n], 0 where fewer than `rank` count: of rows that depend none is near */
double margin_below(const struct phase *f, int rank, const double *q);

/* the part, up to `last`, of the step to end[2n] at which the cubic through its ends comes nearest to dependence; whether rows depend there */
int nearest_part(struct phase *f, const double *end, double last, double *part);

/* the first part of a step, from `part` on, that lies in the middle between two stages of collocation, where a singular configuration disturbs none; 0
 * where none does */
double between_stages(double part);

/* coordinates q[n] at part x of a step of length h to end[2n], on the cubic through its ends */
void between_ends(const struct phase *f, double h, const double *end, double x, double *q);

#endif
