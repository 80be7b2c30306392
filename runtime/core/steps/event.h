/* What ends a step before its end. */
#ifndef CCGEN_EVENT_H
#define CCGEN_EVENT_H

enum { CLOSES = -1, LOST = -2, JAMS = -3 };

struct event {
    int contact;  /* -1: none */
    double theta; /* part of the step */
    int watch; /* CLOSES: the contact's gap; LOST: it was carried, and is not; JAMS: its friction jams; else the watched
                   * value that is negative */
    double behind; /* part of the step at which that value is negative */
};

#endif
