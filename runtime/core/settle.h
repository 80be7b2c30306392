/* Hand-over between flight and contact. */
#ifndef CCGEN_SETTLE_H
#define CCGEN_SETTLE_H

#include "flight.h"

/* Decide which of the closed contacts are held from now on, after all impacts of the instant; put the state where their
 * gaps are shut and do not change. `loss` says which contact cannot be held any more as it was; its contact is -1
 * if there is none. `crowded`: events follow each other
 * without time between them, so what still bounces is taken as at rest. */
enum outcome settle(struct flight *f, struct loss loss, int crowded);

#endif
