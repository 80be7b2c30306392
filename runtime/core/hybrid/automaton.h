/* The hybrid automaton: smooth phases and impacts in turn (docs/events.md has its picture). */
#ifndef CCGEN_AUTOMATON_H
#define CCGEN_AUTOMATON_H

#include "hybrid/time_stepping.h"
#include "motion/switching.h"
#include "steps/step.h"

/* What the automaton does next; automaton.c has a table of what leads where. */
enum stage {
    START,
    MOVE,   /* smooth motion, with some contacts held or with none (flight), to an event or the end of the run */
    MEET,   /* an event: is time getting on, and are links in a line? */
    STRIKE, /* closed contacts that approach strike, all of an instant */
    SELECT, /* contacts that are pressed shut and do not bounce are held from then on */
    STEP,   /* time stepping, where event by event does not get further */
    END,    /* of the run; it may go on */
    STAGES_OF_RUN
};

/* What it remembers of the events so far */
struct automaton {
    enum stage stage;
    struct event event;      /* the last one; its contact is -1 where there was none */
    struct mode_change loss; /* what it took from a held contact */
    int crowds;              /* whether events follow each other without time */
    int struck;              /* whether there was an impact since it */
    int idle;                /* events in a row that changed nothing */
    long events, still;      /* events, and those in a row between which nothing moved */
    double window;           /* when the present window began, in which events are counted, */
    long crowd;              /* events in it of contacts that crowd */
    double quick;        /* the fastest that anything has been in it, in units of coordinates a characteristic time */
    long earlier;        /* and the events before it */
    double instant;      /* when the present instant began: events within INSTANT of it are at once */
    long at_once;        /* events in it */
    double jammed;       /* when friction jammed last */
    struct span span;    /* of time stepping, the present or the last one */
    enum outcome failed; /* what event by event failed with before it, */
    int at_fault;        /* and the contact at fault */
};

/* The automaton of a run that begins */
void start_automaton(struct automaton *a);

/* The speeds of the present state are among those that tell what counts as a motion. */
void note_speed(struct automaton *a, struct phase *f);

/* Whether its stage does anything, and so may be interrupted */
int has_action(const struct automaton *a);

/* One stage, and on to the next. */
enum outcome run_stage(struct automaton *a, struct phase *f);

#endif
