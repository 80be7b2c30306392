/* What rounding leaves known of gaps near configurations where closure rows become dependent (docs/theory, section 8). */
#ifndef CCGEN_FLAT_LOOP_H
#define CCGEN_FLAT_LOOP_H

#include "steps/step.h"

/* Where contacts have gaps so small that the configuration does not tell it from one with dependent rows and these contacts
 * closed, put the state there; `closed` is whether that was done. They must be about to rest, or falling; then velocities are
 * brought to the nearest ones that lead there, or left for the impact that follows. Where steps are `stuck`, gaps somewhat
 * larger are closed too. Afterwards f->unresolved is the size of gaps, relative to the contact's extent, that are not known,
 * and f->flat the time; f->unresolved is 0 where gaps are known as ever. */
enum outcome snap_to_singularity(struct phase *f, int stuck, int *closed);

/* The same for a loop at rest, nearer to such a place than any acceleration is known from: it comes to rest there. What falls by that is lost as in
 * an impact. */
enum outcome lay_flat(struct phase *f);

/* f->dy, as `evaluate_derivative` has it, of a state put where rows are lost. What leaves such a place goes along it to second order of the
 * closure, and its accelerations, which rows that are lost leave free, are those of the limit along its motion. */
enum outcome leave_singularity(struct phase *f);

#endif
