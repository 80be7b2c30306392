/* Many runs of one model: each is reset, goes to its end and leaves its answers in its own places, so that neither the number of threads
 * nor their order shows. A thread has one simulation, whose memory all its runs use one after the other. */
#include "interface/ensemble.h"

#include "base/within.h"
#include "interface/acting.h"
#include "interface/between.h"
#include "interface/calls.h"
#include "interface/crossings.h"
#include "interface/forces.h"
#include "model/contacts.h"
#include "model/scales.h"
#include "motion/projection.h"
#include "motion/rounding.h"

/* What a thread works with */
struct worker {
    struct ensemble *e;
    struct ccgen_simulation *it;
    struct between between;
    struct input_table table;
    struct ccgen_settings settings;
    double *q, *u;                                   /* [n] a start */
    double *u_dot, *lambda, *push, *reaction, *told; /* of one state */
    const double *none;                              /* [1] t = 0 of constant inputs */
};

static const double ZERO[1] = {0.0};

static const double *numbers_of(struct numbers x, size_t run)
{
    return x.of + run * x.every;
}

static int is_to_end(void *context, double t)
{
    struct ensemble *e = context;
    (void)t;
    return atomic_load_explicit(&e->ended, memory_order_relaxed);
}

static int begin_work(struct worker *w, struct ensemble *e)
{
    w->e = e;
    w->settings = *e->settings;
    w->settings.tick = is_to_end;
    w->settings.tick_context = e;
    w->settings.events = does_anything(e->model) ? CCGEN_ACT : CCGEN_IGNORE;
    if (e->parameters.of)
        w->settings.parameters = e->parameters.of;
    if (ccgen_create(e->model, &w->settings, &w->it))
        return 1;
    w->it->run.interruption.at_once = 1; /* it reads one number */
    struct arena *arena = &w->it->arena;
    const struct ccgen_model *m = e->model;
    const size_t n = m->nu;
    w->q = TAKE(arena, double, n);
    w->u = TAKE(arena, double, n);
    w->u_dot = TAKE(arena, double, n);
    w->lambda = TAKE(arena, double, m->rows + 1);
    w->push = TAKE(arena, double, 2 * (size_t)m->contacts + 1);
    w->reaction = TAKE(arena, double, 3 * (size_t)m->joints + 1);
    w->told = TAKE(arena, double, m->told + 1);
    w->none = ZERO;
    return take_between(w->it, &w->between);
}

/* The scales of a mechanism that has not begun to move */
static void forget_scales(struct system *s, double time, const struct run *run)
{
    s->time = time > 0.0 ? time : run->duration;
    s->energy = 1.0;
    set_units(s);
}

/* Whether the accelerations of these parameters lose digits, which are to be recovered then */
static void measure_rounding(struct worker *w)
{
    const struct rounding_sample *sample = &w->e->sample;
    struct system *own = &w->it->system, s = *own; /* without what the run before has left */
    double lost = 0.0, whole = 0.0;
    s.input_source = NULL;
    s.sides = s.latched = NULL;
    s.active = NULL;
    s.baumgarte = 0.0;
    memset(s.inputs, 0, s.model->inputs * sizeof *s.inputs);
    for (size_t k = 0; k < sample->count; k++) {
        double size;
        for (int i = 0; i < s.n; i++) {
            const double scale = sample->lengths[i] ? s.length : 1.0;
            w->q[i] = sample->q[k * s.n + i] * scale;
            w->u[i] = sample->u[k * s.n + i] * scale / s.time;
        }
        lost = fmax(lost, rounding_of_acceleration(&s, 0.0, w->q, w->u, &size));
        whole = fmax(whole, size);
    }
    own->refine = lost > sample->limit * whole;
    own->acceleration_scale = whole;
}

/* Whether a run has parameters with which the equations have constants */
static int give_parameters(struct worker *w, size_t run)
{
    const struct ensemble *e = w->e;
    struct system *s = &w->it->system;
    clear_active_set(&w->it->phase.active, e->model);
    forget_what_events_set(w->it);
    if (!e->parameters.of) {
        forget_scales(s, w->it->time, &w->it->run);
        return 1;
    }
    const double *scales = numbers_of(e->scales, run);
    w->settings.parameters = numbers_of(e->parameters, run);
    w->settings.length = scales[0];
    w->settings.time = scales[1];
    w->settings.acceleration_scale = 0.0;
    set_parameters(w->it, &w->settings);
    if (!all_finite(e->model->constants, s->k))
        return 0;
    measure_rounding(w);
    return 1;
}

static void give_inputs(struct worker *w, size_t run)
{
    const struct ensemble *e = w->e;
    struct system *s = &w->it->system;
    if (e->table)
        w->table = *e->table;
    else if (e->inputs.of)
        w->table = (struct input_table){1, own_inputs(e->model), w->none, numbers_of(e->inputs, run), 0};
    memset(s->inputs, 0, e->model->inputs * sizeof *s->inputs);
    if (!e->table && !e->inputs.of)
        return;
    s->input_source = input_from_table;
    s->context = &w->table;
}

/* Whether a start can be put onto the closure, has an energy, and is inside nothing. */
static int give_start(struct worker *w, size_t run)
{
    const struct ensemble *e = w->e;
    struct system *s = &w->it->system;
    double energy[2];
    memcpy(w->q, numbers_of(e->q, run), (size_t)s->n * sizeof *w->q);
    memcpy(w->u, numbers_of(e->u, run), (size_t)s->n * sizeof *w->u);
    if (!e->projections)
        return 1;
    for (int i = 0; i < e->projections; i++) {
        s->model->energy(s->k, w->q, w->u, energy);
        if (!all_finite(2, energy) || project_position(s, w->q) || project_velocity(s, w->q, w->u))
            return 0;
    }
    double *gaps = w->it->phase.gaps;
    if (s->model->contacts)
        s->model->gaps(s->k, w->q, gaps);
    for (int c = 0; c < s->model->contacts; c++)
        if (!(-gaps[c] <= e->deepest * s->length))
            return 0;
    return 1;
}

static void write_nan(double *x, size_t count)
{
    for (size_t i = 0; x && i < count; i++)
        x[i] = NAN;
}

static void copy_to(double *to, const double *from, size_t count)
{
    if (to)
        memcpy(to, from, count * sizeof *to);
}

/* Accelerations and forces at a state of the run, or NAN where they are not known */
static void write_forces(struct worker *w, size_t place, double t, const double *q, const double *u)
{
    struct ensemble *e = w->e;
    const struct ccgen_model *m = e->model;
    const size_t n = m->nu, rows = m->rows + 1, pushes = 2 * (size_t)m->contacts, joints = 3 * (size_t)m->joints;
    struct between *b = &w->between;
    struct system s = w->it->system;
    struct obstruction found;
    char unknown = 0;
    s.interruption = NULL;
    s.unit = b->unit;  /* the run's own stay for the states that follow */
    s.baumgarte = 0.0; /* what damps drift is no force */
    s.sides = NULL;
    forget_scales(&s, w->it->time, &w->it->run);
    held_at(w->it, b, t, 0);
    latched_at(w->it, b, t);
    const struct held held = {b->count, b->set, b->mode, 1};
    memset(w->push, 0, pushes * sizeof *w->push);
    if (stepped_at(w->it, t) ||
        held_forces(&s, 1, 0, &t, q, u, m->latches ? b->latched : NULL, held, w->u_dot, w->lambda, w->push, w->reaction,
                    w->told, &unknown, &found) ||
        unknown || found.why) {
        write_nan(w->u_dot, n);
        write_nan(w->lambda, rows);
        write_nan(w->push, pushes);
        write_nan(w->reaction, joints);
        write_nan(w->told, m->told);
    }
    copy_to(e->u_dot + place * n, w->u_dot, n);
    copy_to(e->lambda + place * rows, w->lambda, rows);
    copy_to(e->push + place * pushes, w->push, pushes);
    copy_to(e->reaction + place * joints, w->reaction, joints);
    copy_to(e->told + place * m->told, w->told, m->told);
}

/* Where links, points and contacts are at a state, and how they move */
static void write_places(struct worker *w, size_t place, const double *q, const double *u)
{
    const struct ensemble *e = w->e;
    const struct ccgen_model *m = e->model;
    const double *k = w->it->system.k;
    m->poses(k, q, e->pose + place * 3 * m->links);
    m->velocities(k, q, u, e->velocity + place * 3 * m->links);
    m->energy(k, q, u, e->energy + place * 2);
    if (m->points)
        m->point_positions(k, q, e->point + place * 2 * m->points);
    if (m->contacts) {
        m->gaps(k, q, e->gap + place * m->contacts);
        m->gap_rates(k, q, u, e->gap_rate + place * m->contacts);
    }
}

/* What is asked for at times from `since` on, up to where the run has come, or before that: events that set parameters come there, and what is told of
 * them is as after that. */
static void write_states(struct worker *w, size_t run, double since, int to_end)
{
    const struct ensemble *e = w->e;
    const struct record *record = &w->it->run.record;
    const size_t n = e->model->nu;
    const double last = record->t[record->count - 1];
    for (size_t k = 0; k < e->times; k++) {
        const double t = e->at ? e->at[k] : last;
        const size_t place = run * e->times + k;
        double *q = e->state + place * 2 * n, *u = q + n;
        if (!(e->at || to_end) || t < since || !(to_end ? t <= last : t < last) ||
            state_at(w->it, &w->between, t, q, u))
            continue;
        if (e->pose)
            write_places(w, place, q, u);
        if (e->u_dot)
            write_forces(w, place, t, q, u);
    }
}

static void write_answers(struct worker *w, size_t run)
{
    const struct ensemble *e = w->e;
    const struct ccgen_simulation *it = w->it;
    const struct impacts *impacts = &it->run.impacts;
    const size_t n = e->model->nu, kept = e->impact_times;
    e->outcome[run] = it->run.outcome;
    e->contact[run] = it->run.contact;
    e->steps[run] = (long)it->run.record.count - 1;
    e->impacts[run] = (long)impacts->count;
    memcpy(e->end + run * (2 * n + 1), it->phase.y, 2 * n * sizeof *e->end);
    e->end[run * (2 * n + 1) + 2 * n] = it->phase.t;
    for (size_t k = 0; k < kept; k++)
        e->impact_t[run * kept + k] = k < impacts->count ? impacts->t[k] : NAN;
    if (e->reduce && e->reduce(e->context, it->run.record.t, it->run.record.y, it->run.record.count,
                               it->system.size + it->system.model->latches, e->reduction + run * e->reduced))
        write_nan(e->reduction + run * e->reduced, e->reduced);
}

static void make_run_of(struct worker *w, size_t run)
{
    struct ensemble *e = w->e;
    struct ccgen_simulation *it = w->it;
    if (!give_parameters(w, run)) {
        e->outcome[run] = ROW_REFUSED;
        return;
    }
    give_inputs(w, run);
    if (!give_start(w, run)) {
        e->outcome[run] = ROW_REFUSED;
        return;
    }
    e->outcome[run] = reset(it, 0.0, w->q, w->u);
    if (e->outcome[run])
        return;
    watch_from_start(it);
    double since = it->run.record.t[0];
    int acts = 1, ends = 0;
    while (acts) {
        const enum outcome outcome = simulate(it, e->until, &acts);
        acts = acts && !outcome;
        if (acts && e->times)
            write_states(w, run, since, 0);
        since = acts ? it->phase.t : since;
        if (acts && (act(it, &ends) || ends))
            acts = 0;
    }
    if (e->times)
        write_states(w, run, since, 1);
    write_answers(w, run);
}

enum outcome work_on(struct ensemble *e)
{
    struct worker w = {0};
    enum outcome outcome = OUTCOME_NO_MEMORY;
    if (!begin_work(&w, e)) {
        outcome = OUTCOME_DONE;
        while (!atomic_load_explicit(&e->ended, memory_order_relaxed)) {
            const size_t run = atomic_fetch_add_explicit(&e->next, 1, memory_order_relaxed);
            if (run >= e->count)
                break;
            if (e->outcome[run] == ROW_NOT_BEGUN) /* not one that is known to be refused */
                make_run_of(&w, run);
            atomic_fetch_add_explicit(&e->done, 1, memory_order_relaxed);
        }
    }
    ccgen_destroy(w.it);
    return outcome;
}

void begin_ensemble(struct ensemble *e)
{
    atomic_store(&e->next, 0);
    atomic_store(&e->done, 0);
    atomic_store(&e->ended, 0);
}

void end_ensemble(struct ensemble *e)
{
    atomic_store(&e->ended, 1);
}

size_t done_of(struct ensemble *e)
{
    return atomic_load(&e->done);
}
