/* Hand-over between flight and contact. */
#ifndef CCGEN_CONTACT_TRANSITION_H
#define CCGEN_CONTACT_TRANSITION_H

#include "motion/switching.h"
#include "steps/step.h"

/* which contacts that bounce are said to be at rest: none, all, or otherwise the one of that number */
enum { NONE_RESTS = -1, ALL_REST = -2 };

/* Decide which of the closed contacts are held from now on, after all impacts of the instant; put the state where their
 * gaps are shut and do not change. `loss` says which contact cannot be held any more as it was; its contact is -1
 * if there is none. `resting` says what is at rest although it bounces, because events follow each other
 * without time between them. */
enum outcome select_active_set(struct phase *f, struct mode_change loss, int resting);

/* Which of the closed contacts are held at the state, which stays as it is: they are then held in f->s->holding. Contact
 * *strikes approaches so fast that an impact comes first, and does not count; it is -1 if there is none. The flight needs its
 * y, dy, gaps, rates and set alone. */
enum outcome would_activate(struct phase *f, int *strikes);

/* Let go of all contacts, which is recorded. */
enum outcome release_contacts(struct phase *f);

#endif
