/* The active set: the contacts that stay closed, how each moves along its ground, and its rows (docs/events.md). */
#ifndef CCGEN_ACTIVE_SET_H
#define CCGEN_ACTIVE_SET_H

#include "model/system.h"

/* How a contact stays closed, or that it does not: its number, and its name in Python. IMPLIED: others keep it closed, or driven joints. GRAZING: it
 * touches without pressing, and so without the friction that it may have, as between bodies that move side by side. AT_LIMIT: its
 * friction is at the limit, against forward or backward sliding, while other contacts that stick keep it where it is. What slides
 * has the sign of its sliding, what is at the limit that of the sliding that friction is against. */
#define ALL_CONTACT_MODES(X)                           \
    X(SLIP_BACKWARD, -1, "slides backward")            \
    X(FRICTIONLESS, 0, "smooth")                       \
    X(SLIP_FORWARD, 1, "slides forward")               \
    X(STICK, 2, "sticks")                              \
    X(AT_LIMIT_FORWARD, 3, "at the limit, forward")    \
    X(AT_LIMIT_BACKWARD, -3, "at the limit, backward") \
    X(GRAZING, 4, "touches")                           \
    X(IMPLIED, 5, "carried")                           \
    X(OPEN, 6, "apart")

#define ENTRY(name, number, text) name = number,
enum contact_mode { ALL_CONTACT_MODES(ENTRY) };
#undef ENTRY

/* whether a contact is watched for impacts (0), or closed: by a force of its own, or implied by others or by driven joints */
enum { WATCHED, PUSHING, CARRIED };

/* the sign of the sliding that friction is against at its limit; 0 where it is not at the limit */
static inline int against(int mode)
{
    return mode == STICK || mode == GRAZING ? 0 : (mode > 0) - (mode < 0);
}

/* The contacts that are held closed. Those of `set` push, each as hard as it must for its gap to stay what it is, or touch;
 * others are closed because these carry them, or driven joints. With no contact in `set` the motion is flight. Each is a row of a problem in
 * the forces; those that stick have a second, tangential row, below all others. */
struct active_set {
    int count;         /* contacts that push, or touch */
    int *set;          /* [count] which */
    signed char *mode; /* [count] enum contact_mode */
    int rows;          /* count, and how many of them stick */
    int *of;           /* [rows] the contact of each row, as a number in `set` */
    double *force;     /* [rows] N, of the last acceleration */
    int open;          /* whether others would give the same: these are of least norm */
    double *least;     /* [count] N: what the force of one that touches without pressing is known to; 0 of others */
    double *
        peak; /* [contacts] N: the most that each has pushed with since nothing was held, or since the last impact at which no closure row was
                        * nearly dependent */
    char *closed; /* [contacts] WATCHED for impacts, or closed: PUSHING, or CARRIED by others */
    int *
        twin; /* [contacts] the contact that bears in place of one that is carried and touches as it does, or -1: constraints/twins.c */
    int implied;   /* how many are carried */
    double window; /* s: what eight pieces last showed the watched values in; 0 where that is not known */
};

/* An active set in which nothing is held; its arrays are the arena's. 0, or 1 when memory runs out */
int take_active_set(struct arena *arena, struct active_set *h, const struct ccgen_model *m);

/* Nothing is held, and nothing is known of forces. */
void clear_active_set(struct active_set *h, const struct ccgen_model *m);

/* What `from` is; both belong to the same model. */
void copy_active_set(struct active_set *to, const struct active_set *from, int contacts);

/* How each contact is held, modes[contacts]: enum contact_mode */
void contact_modes(const struct active_set *h, int contacts, signed char *modes);

/* Hold `count` contacts `set`, with their modes: what follows from it. */
void activate(struct active_set *h, int count, const int *set, const signed char *mode);

/* Entries of a column of contacts' impulses: the normal ones of all contacts, then with friction the tangential ones */
static inline int width_of(const struct system *s)
{
    return s->friction ? 2 * s->model->contacts : s->model->contacts;
}

/* bias[rows] (m/s^2) of the held contacts; rates[contacts] and slips[contacts] are scratch. */
void bias_of_active(const struct system *s, const double *q, const double *u, double *rates, double *slips,
                    double *bias);

/* found[rows] (m/s) of the first rows of the held contacts, of velocities u or accelerations without bias; scratch likewise */
void rates_of_active(const struct system *s, const double *q, const double *u, int rows, double *rates, double *slips,
                     double *found);

/* Generalized forces f[n] of row number `row`, without the friction of a contact that slides; push[contacts] are zeros, and so again
 * afterwards. */
void active_row(const struct system *s, const double *q, int row, double *push, double *f);

/* Whether a carried contact has one that bears in its place */
static inline int has_twin(const struct active_set *h, int contact)
{
    return h->closed[contact] == CARRIED && h->twin[contact] >= 0;
}

/* How many contacts are held */
static inline int active_count(const struct system *s)
{
    return s->active ? s->active->count : 0;
}

/* Whether the friction of one of them is at its limit, and so may do work */
static inline int any_slides(const struct system *s)
{
    for (int i = 0; i < active_count(s); i++)
        if (against(s->active->mode[i]))
            return 1;
    return 0;
}

/* How many rows they have; in a projection of the position all contacts have one */
static inline int active_rows(const struct system *s, int speed)
{
    return s->active ? speed ? s->active->rows : s->active->count : 0;
}

#endif
