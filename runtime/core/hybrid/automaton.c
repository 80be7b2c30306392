/* The hybrid automaton; see automaton.h. */
#include "hybrid/automaton.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "hybrid/contact_transition.h"
#include "impact/impact.h"
#include "steps/flat_loop.h"
#include "steps/phase.h"

static const double INSTANT = 1e-10; /* s, relative to max(1, t): the time within which events crowd */
enum {
    REPEATS = 1000, /* impacts at one instant */
    CROWD = 200,    /* events within an instant before what bounces is said to be at rest */
    RATTLE = 1000,  /* the same of events between which no closed contact moves */
    IDLE =
        10 /* events of a gap that neither take time nor lead to an impact, before its contact is said to be at rest */
};
static const double UNSEEN = 16.0; /* units of rounding: a gap that changes less between two events has not moved */

/* Work (J) of the impulses of friction in an impact of the contacts f->set */
static double friction_work(struct phase *f, int count, const double *u_plus)
{
    const struct system *s = f->s;
    double *slips = f->search, work = 0.0;
    for (int side = 0; s->friction && side < 2; side++) {
        s->model->slips(s->k, f->y, side ? u_plus : f->y + s->n, slips);
        for (int i = 0; i < count; i++)
            work += 0.5 * f->P[count + i] * slips[f->set[i]];
    }
    return work;
}

/* Energy (J) that the contacts f->set take in an impact, at speeds f->rates before it */
static double contact_loss(struct phase *f, int count, const double *u_plus)
{
    double loss = 0.0, *after = f->search;
    f->s->model->gap_rates(f->s->k, f->y, u_plus, after);
    for (int i = 0; i < count; i++)
        loss -= 0.5 * f->P[i] * (f->rates[f->set[i]] + after[f->set[i]]);
    return loss - friction_work(f, count, u_plus);
}

/* The same where driven joints, which do not change their speeds, do work in an impact too: what the mechanism loses */
static double jump_loss(struct phase *f, const double *u_plus)
{
    const struct system *s = f->s;
    const int n = s->n;
    double loss = 0.0, *jump = f->search, *momentum = f->dy1;
    const double *u = f->y + n;
    for (int i = 0; i < n; i++)
        jump[i] = u_plus[i] - u[i];
    s->model->momentum(s->k, f->y, jump, momentum);
    for (int i = 0; i < n; i++)
        loss -= 0.5 * (u[i] + u_plus[i]) * momentum[i];
    return loss;
}

/* All impacts of one instant: those contacts that are closed and not opening are struck together; if a closed contact is
 * left approaching, another impact follows. `trigger` is the contact whose event led here, or -1. */
static enum outcome resolve_impacts(struct phase *f, int trigger)
{
    const struct ccgen_model *m = f->s->model;
    struct run *run = f->run;
    const int n = f->s->n;
    for (int repeat = 0;; repeat++) {
        if (interrupted(f->s->interruption, 0))
            return OUTCOME_INTERRUPTED;
        int count = 0, approaching = 0;
        m->gaps(f->s->k, f->y, f->gaps);
        m->gap_rates(f->s->k, f->y, f->y + n, f->rates);
        for (int c = 0; c < m->contacts; c++) {
            const double closed = gap_tolerance(f, c), still = rest_velocity(f, c);
            if ((f->gaps[c] <= closed || (c == trigger && !repeat)) && f->rates[c] <= still) {
                approaching |= f->rates[c] < -still || (c == trigger && !repeat && f->rates[c] < 0.0);
                f->e[count] = f->s->restitution[c];
                f->set[count++] = c;
            }
        }
        if (!approaching)
            break;
        if (repeat == REPEATS)
            return OUTCOME_REPEATS;
        activate(f->s->active, 0, NULL, NULL); /* what was held may leave now */
        double *u_plus = f->y1 + n;
        enum outcome outcome = impact(f->s, f->y, f->y + n, count, f->set, f->e, u_plus, f->P);
        if (outcome) {
            run->contact = f->set[0];
            return outcome;
        }
        const double loss = m->drives ? jump_loss(f, u_plus) : contact_loss(f, count, u_plus);
        if (record_state(f) ||
            append_impact(&run->impacts, f->t, f->y + n, u_plus, n, count, f->set, f->P, loss, run->record.count))
            return OUTCOME_NO_MEMORY;
        memcpy(f->y + n, u_plus, n * sizeof *u_plus);
        if (record_state(f))
            return OUTCOME_NO_MEMORY;
    }
    return OUTCOME_DONE;
}

/* Whether the closed contacts have moved since an event `since` ago by less than positions can show */
static int chatters(struct phase *f, double since)
{
    const struct ccgen_model *m = f->s->model;
    m->gaps(f->s->k, f->y, f->gaps);
    m->gap_rates(f->s->k, f->y, f->y + f->s->n, f->rates);
    for (int c = 0; c < m->contacts; c++)
        if (f->gaps[c] <= gap_tolerance(f, c) && fabs(f->rates[c]) * since > UNSEEN * DBL_EPSILON * f->s->extent[c])
            return 0;
    return 1;
}

enum outcome run_automaton(struct phase *f)
{
    struct event event = {-1, 0.0, LOST, 1.0};
    double last[2 * CROWD];     /* instants of the last events */
    long events = 0, still = 0; /* `still`: events in a row between which nothing moved */
    int idle = 0;               /* events in a row that changed nothing */
    if (!f->s->model->contacts)
        return integrate_to_event(f, &event);
    enum outcome outcome = resolve_impacts(f, -1);
    if (!outcome)
        outcome = select_active_set(f, (struct mode_change){-1, DETACHES}, NONE_RESTS);
    while (!outcome && f->t < f->run->until) {
        const double before = f->t;
        outcome = integrate_to_event(f, &event);
        if (outcome || event.contact < 0)
            continue;
        still = chatters(f, f->t - before) ? still + 1 : 0;
        const double now = f->t - INSTANT * fmax(1.0, f->t);
        const int events_crowd = still >= RATTLE || (events >= CROWD && now <= last[(events - CROWD) % (2 * CROWD)]);
        if (events >= 2 * CROWD && now <= last[events % (2 * CROWD)]) {
            f->run->contact = event.contact;
            return OUTCOME_ACCUMULATION;
        }
        last[events++ % (2 * CROWD)] = f->t;
        f->run->events++;
        const struct mode_change none = {-1, DETACHES},
                                 loss = event.watch >= 0 ? mode_change_of(f->s, event.watch) : none;
        const size_t impacts = f->run->impacts.count;
        int closed;
        if (event.watch != FLAT)
            outcome = snap_to_singularity(f, 0, &closed);
        if (!outcome)
            outcome = resolve_impacts(f, event.watch == CLOSES ? event.contact : -1);
        const int struck = f->run->impacts.count > impacts;
        idle = !struck && event.watch == CLOSES && f->t == before ? idle + 1 : 0;
        if (!outcome) /* what was lost is asked anew where an impact has changed it */
            outcome = select_active_set(f, struck ? none : loss,
                                        events_crowd   ? ALL_REST
                                        : idle >= IDLE ? event.contact
                                                       : NONE_RESTS);
    }
    return outcome;
}
