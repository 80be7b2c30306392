/* Contacts that stay closed: which are held, what holds them, and when that ends (docs/events.md). */
#ifndef CCGEN_CONTACT_H
#define CCGEN_CONTACT_H

#include "core.h"

/* how a contact is held */
enum { APART, HELD, CARRIED };

/* how a held contact moves along its ground: it is smooth; it slides forward (1) or backward (-1); it sticks; or its friction
 * is at the limit, against forward (3) or backward (-3) sliding, while other contacts that stick keep it where it is; or
 * it touches without pressing, and so without the friction that it may have, as between bodies that move side by side */
enum { SMOOTH = 0, STICKS = 2, LIMIT = 3, TOUCHES = 4 };

/* the sign of the sliding that friction is against at its limit; 0 where it is not at the limit */
static inline int against(int slide)
{
    return slide == STICKS || slide == TOUCHES ? 0 : (slide > 0) - (slide < 0);
}

/* how a held contact ends being held as it is; STIRS: what touched without pressing presses or pulls */
enum { PULLS, STOPS, GIVES_FORWARD, GIVES_BACKWARD, STIRS };

struct loss {
    int contact, how;
};

/* The contacts that are held closed. Those of `set` push, each as hard as it must for its gap to stay what it is, or touch;
 * others are closed because these carry them. With no contact in `set` the motion is flight. Each is a row of a problem in
 * the forces; those that stick have a second, tangential row, below all others. */
struct holding {
    int count;          /* contacts that push, or touch */
    int *set;           /* [count] which */
    signed char *slide; /* [count] how they move along their grounds */
    int rows;           /* count, and how many of them stick */
    int *of;            /* [rows] the contact of each row, as a number in `set` */
    double *force;      /* [rows] N, of the last acceleration */
    double *least;      /* [count] N: what the force of one that touches without pressing is known to; 0 of others */
    double *peak;       /* [contacts] N: the most that each has pushed with since nothing was held */
    double *weight;     /* [rows] how much a row bears where forces can be shared: friction by the square root of its limit */
    char *closed;       /* [contacts] APART, HELD or CARRIED; only those apart are watched for impacts */
    int carried;        /* how many are carried */
    double window;      /* s: what eight pieces last showed the watched values in; 0 where that is not known */
    double *columns;    /* [2 contacts][n] motion that a unit impulse of each row gives, loops held shut */
    double *W;          /* [2 contacts][2 contacts] rates that it gives */
    double *units;      /* [2 contacts][2 contacts] impulses, a column for each row; zero between calls */
    double *answers;    /* [2 contacts][2 contacts] rates of all contacts that each column gives */
    double *wanted;     /* [2 contacts] scratch */
    double *rates;      /* [contacts] scratch */
    double *slips;      /* [contacts] scratch */
    double *pushes;     /* [contacts] scratch, zero between calls */
    double *f, *g;      /* [n] scratch */
    double *solved;     /* scratch of the solution */
};

/* 0, or 1 when memory runs out */
int make_holding(struct holding *h, const struct ccgen_model *m);
void free_holding(struct holding *h);

/* Hold `count` contacts `set`, `slide` as above: what follows from it. */
void hold_contacts(struct holding *h, int count, const int *set, const signed char *slide);

/* Rates of the contacts `set` that unit impulses along their normals give, and if the model is rough, along their tangents
 * below them: columns[k][n], W[k][k] with k = count or 2 count, symmetric; units[k][entries of a column of contacts'
 * impulses], answers the same, pushes[contacts], rates[contacts], f[n] scratch */
enum outcome compliance(struct system *s, const double *q, int count, const int *set, double *columns, double *W,
                        double *units, double *answers, double *pushes, double *rates, double *f);

/* Entries of a column of contacts' impulses: the normal ones of all contacts, then with friction the tangential ones */
static inline int width_of(const struct system *s)
{
    return s->friction ? 2 * s->model->contacts : s->model->contacts;
}

/* Add to the accelerations of the free system what the held contacts do, each as much as its gap needs. Nonzero where they
 * nearly depend on each other or on the closure, 2 where friction jams: the result is then not to be used. */
int hold_acceleration(struct system *s, const double *q, const double *u, double *u_dot);

/* Add to the jump du the impulses of the held contacts that bring the rates of their gaps, and with `speed` their sliding
 * where they stick, to wanted[rows] (m/s); nonzero likewise. */
int hold_jump(struct system *s, const double *q, int speed, const double *wanted, double *du);

/* bias[rows] (m/s^2) of the held contacts; returns how many rows they have. */
int held_bias(struct system *s, const double *q, const double *u, double *bias);

/* Generalized forces f[n] of row number `row`; `friction`: with the friction of a contact that slides. */
void held_row(struct system *s, const double *q, int row, int friction, double *f);

/* What must stay positive for the held contacts to stay as they are, values[watched], and what number `index` is about.
 * dy[size] is the derivative at (t, y). */
int watched(const struct system *s);
struct loss watcher(const struct system *s, int index);
enum outcome watch(struct system *s, double t, const double *y, double *dy, double *values);

/* How many contacts are held */
static inline int holds(const struct system *s)
{
    return s->holding ? s->holding->count : 0;
}

/* How many rows they have; in a projection of the position all contacts have one */
static inline int held_rows(const struct system *s, int speed)
{
    return s->holding ? speed ? s->holding->rows : s->holding->count : 0;
}

#endif
