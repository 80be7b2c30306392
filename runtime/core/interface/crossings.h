/* The instants of the events of a scene along a run; see crossings.c. */
#ifndef CCGEN_CROSSINGS_H
#define CCGEN_CROSSINGS_H

#include "interface/between.h"

/* Look along what is recorded and was not looked at yet. What a look finds stays found. */
enum outcome find_crossings(struct ccgen_simulation *it);

/* 0, or 1 when memory runs out */
int take_watch(struct ccgen_simulation *it);

/* Forget what was found: a run goes on from a state, in which indicators that are at or beyond zero have to go below first. A run that halts does so at the next event of each, one that
 * acts at those that do something. */
void begin_watch(struct ccgen_simulation *it);

/* The same for a run that begins from its start: joints that let go or take hold at that very time do. */
void watch_from_start(struct ccgen_simulation *it);

/* Room for the state before a leg of a run that halts */
char *begin_halting(struct ccgen_simulation *it);

/* The event at which a run is to end: when it comes, when the step in which it does ends, and its indicator, or -1 */
struct halt {
    double t, latest;
    int indicator;
};

/* Look for it along what was not looked at yet; it stays where there is none. */
enum outcome find_halt(struct ccgen_simulation *it, struct halt *halt);

/* How long (s) it is from the end of the run to where that event comes; 0 where the indicator is not below zero any more. */
double short_of_halt(struct ccgen_simulation *it);

/* A run has ended, at that event: what was found later than `together` (s) after it has not come, and what comes next is told from where the run is. */
void end_at_halt(struct ccgen_simulation *it, double together);

/* The crossings of the instant at which a run has halted, in the order of their tables; and the number of the first of them */
const struct ccgen_crossing *crossings_of_instant(const struct ccgen_simulation *it, size_t *first, size_t *count);

/* Whether the event of an indicator, which has come there, ends the run by that */
int stops_motion(struct ccgen_simulation *it, int indicator);

/* Motion has begun anew where it was: what is to come is looked for from there. */
void watch_anew(struct ccgen_simulation *it);

/* Keep what is known of events where a leg of a run that halts begins, and put it back. */
void keep_watch(struct ccgen_simulation *it);
void restore_watch(struct ccgen_simulation *it);

/* As find_crossings, also behind an interruption */
enum outcome look_at_all(struct ccgen_simulation *it);

/* The record begins anew at its last row. */
void forget_rows_looked_at(struct ccgen_simulation *it);

void free_watch(struct ccgen_simulation *it);

#endif
