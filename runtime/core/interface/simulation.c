/* A simulation; see ../../ccgen.h. */
#include "interface/simulation.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/within.h"
#include "hybrid/contact_transition.h"
#include "constraints/place.h"
#include "hybrid/state.h"
#include "impact/law.h"
#include "methods/gauss.h"
#include "model/contacts.h"
#include "model/scales.h"
#include "motion/jacobian.h"
#include "motion/projection.h"
#include "steps/kinks.h"
#include "steps/pace.h"
#include "steps/phase.h"
#include "steps/step_control.h"
#include "steps/step_end.h"

static const double BAUMGARTE = 20.0; /* rate of Baumgarte's stabilisation, per characteristic time */
static const double RTOL = 1e-9;
static const long STEP_BUDGET = 10000000, RATE_BUDGET = 200000;

/* Bytes of scratch that functions have at one time at most. The largest arrays are squares. With n coordinates, r rows of the closure and
 * of drives, and k contacts: a decision on which contacts are held has 45 k^2 numbers, with its problem of friction and the tableau
 * in which that is pivoted, and an impact has 33 k^2 and its columns, 2 k n; the null space has 2 n^2, and (r + 2 k) (n + r + 2 k)
 * of rows where contacts are held, while a decision has 18 k^2 and columns. All are less than 2 (n + r + 5 k)^2. What grows with
 * the sizes themselves, as samples of switching functions in a step, is less than 64 times them. Jacobians from generated derivatives
 * take a column for every direction, and say themselves how much. */
static size_t scratch_of(const struct ccgen_model *m)
{
    const size_t all = m->nu + m->rows + m->drives + 5 * (size_t)m->contacts;
    const size_t most = 2 * all * all > jacobian_scratch(m) ? 2 * all * all : jacobian_scratch(m);
    return (most + 64 * (all + m->links + m->switches + m->indicators)) * sizeof(double) + 4096;
}

void keep_closed(struct system *s, enum drift drift)
{
    s->projects_steps = drift == DRIFT_PROJECTED;
    s->baumgarte = drift == DRIFT_DAMPED ? BAUMGARTE : 0.0;
}

/* The constants as they were if all joints held */
static void derive_as_held(struct ccgen_simulation *it, const double *parameters)
{
    const struct ccgen_model *m = it->system.model;
    memcpy(it->all_held, parameters, m->parameters * sizeof *parameters);
    for (int r = 0; r < m->rows; r++)
        if (m->row_held[r] >= 0)
            it->all_held[m->row_held[r]] = 1.0;
    m->derive_constants(it->all_held, it->k_held);
}

static void derive_constants(struct ccgen_simulation *it, const double *parameters)
{
    const struct ccgen_model *m = it->system.model;
    m->derive_constants(parameters, it->k);
    it->system.rows_on = find_rows_on(m, parameters, it->on);
    if (m->joint_of)
        derive_as_held(it, parameters);
    if (m->contacts)
        m->restitution(it->k, it->restitution);
    if (m->friction)
        m->friction(it->k, it->friction);
}

void derive_parameters(struct ccgen_simulation *it)
{
    derive_constants(it, it->run.values);
}

void forget_what_events_set(struct ccgen_simulation *it)
{
    if (it->run.values && it->changed) {
        memcpy(it->run.values, it->given, it->system.model->parameters * sizeof *it->given);
        derive_parameters(it);
    }
    it->changed = 0;
}

void set_parameters(struct ccgen_simulation *it, const struct ccgen_settings *settings)
{
    struct system *s = &it->system;
    s->length = settings->length > 0.0 ? settings->length : 1.0;
    derive_constants(it, settings->parameters);
    if (it->given && s->model->parameters) {
        memcpy(it->given, settings->parameters, s->model->parameters * sizeof *it->given);
        memcpy(it->run.values, it->given, s->model->parameters * sizeof *it->given);
    }
    it->changed = 0;
    set_levers(s, settings->angular, it->lever, it->extent);
    it->time = settings->time;
    s->time = it->time > 0.0 ? it->time : it->run.duration;
    s->energy = 1.0;
    set_units(s);
    s->refine = settings->acceleration_scale > 0.0;
    s->acceleration_scale = settings->acceleration_scale;
}

/** Whether each gate of rows is 1 or 0: any other number would leave its rows on in part. */
static int gates_are_whole(const struct ccgen_model *m, const double *parameters)
{
    for (int r = 0; m->row_held && r < m->rows; r++) {
        const double held = m->row_held[r] >= 0 ? parameters[m->row_held[r]] : 1.0;
        if (held != 0.0 && held != 1.0)
            return 0;
    }
    return 1;
}

static enum outcome make_system(struct ccgen_simulation *it, const struct ccgen_model *m,
                                const struct ccgen_settings *settings)
{
    struct system *s = &it->system;
    struct arena *arena = s->arena = &it->arena;
    unsigned char *lengths = TAKE(arena, unsigned char, m->nu);
    it->k = TAKE_ZEROS(arena, double, m->constants);
    it->on = TAKE(arena, int, m->rows);
    it->k_held = TAKE_ZEROS(arena, double, m->joint_of ? m->constants : 0);
    it->all_held = TAKE_ZEROS(arena, double, m->joint_of ? m->parameters : 0);
    it->extent = TAKE_ZEROS(arena, double, m->contacts);
    it->lever = TAKE(arena, double, m->contacts);
    it->restitution = TAKE_ZEROS(arena, double, m->contacts);
    it->friction = TAKE_ZEROS(arena, double, m->contacts);
    s->inputs = TAKE_ZEROS(arena, double, m->inputs);
    s->unit = TAKE(arena, double, 2 * (size_t)m->nu + 1);
    if (settings->events == CCGEN_ACT) {
        it->given = TAKE_ZEROS(arena, double, m->parameters + 1);
        it->kept = TAKE_ZEROS(arena, double, m->parameters + 1);
        it->run.values = TAKE_ZEROS(arena, double, m->parameters + 1);
        it->event_values = TAKE_ZEROS(arena, double, m->event_values + 1);
        it->held = TAKE_ZEROS(arena, double, m->latches + 1);
        it->was = TAKE_ZEROS(arena, double, m->parameters + 1);
        it->wanted = TAKE_ZEROS(arena, double, m->parameters + 1);
        it->on_event = settings->on_event;
        it->event_context = settings->event_context;
        it->answered = settings->answered;
    }
    if (arena->ran_out)
        return OUTCOME_NO_MEMORY;
    s->model = m;
    s->n = m->nu;
    s->size = 2 * m->nu + (m->power || m->friction);
    for (int i = 0; i < s->n; i++)
        lengths[i] = settings->lengths ? settings->lengths[i] : i < m->base;
    s->lengths = lengths;
    s->k = it->k;
    s->on = it->on;
    s->restitution = it->restitution;
    s->friction = m->friction ? it->friction : NULL;
    if (!(s->law = find_law(settings->law ? settings->law : newton.name)))
        return OUTCOME_UNKNOWN_LAW;
    if (!gates_are_whole(m, settings->parameters))
        return OUTCOME_BAD_SETTINGS;
    set_parameters(it, settings);
    keep_closed(s, (enum drift)settings->drift);
    s->input_source = settings->inputs;
    s->context = settings->context;
    return OUTCOME_DONE;
}

static enum outcome make_run(struct run *run, const struct ccgen_settings *settings)
{
    const double rtol = settings->rtol > 0.0 ? settings->rtol : RTOL;
    run->tolerance = (struct tolerance){.rtol = rtol, .atol = settings->atol > 0.0 ? settings->atol : rtol};
    run->method = find_method(settings->method ? settings->method : gauss.name);
    run->stops = settings->stops;
    run->stop_count = settings->stop_count;
    run->fixed_step = settings->fixed_step;
    run->step_budget = settings->step_budget ? settings->step_budget : STEP_BUDGET;
    run->duration = settings->duration > 0.0 ? settings->duration : 1.0;
    run->rate_budget = settings->rate_budget ? settings->rate_budget : RATE_BUDGET;
    run->on_gain = (enum gain)settings->on_gain;
    run->interruption.tick = settings->tick;
    run->interruption.context = settings->tick_context;
    const double numbers[] = {
        settings->rtol, settings->atol,    settings->fixed_step, settings->length, settings->acceleration_scale,
        settings->time, settings->duration};
    int wrong = settings->events < CCGEN_IGNORE || settings->events > CCGEN_ACT;
    wrong |= settings->on_event && settings->events != CCGEN_ACT;
    wrong |= !ccgen_drift_name(settings->drift) || !ccgen_gain_name(settings->on_gain) || !(rtol < 1.0);
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++)
        wrong |= !(numbers[i] >= 0.0 && isfinite(numbers[i]));
    for (size_t i = 0; i + 1 < settings->stop_count; i++)
        wrong |= !(settings->stops[i] <= settings->stops[i + 1]);
    if (run->method && run->fixed_step == 0.0) /* nothing else could choose the steps */
        wrong |= !estimates_errors(run->method);
    return wrong ? OUTCOME_BAD_SETTINGS : run->method ? OUTCOME_DONE : OUTCOME_UNKNOWN_METHOD;
}

int does_anything(const struct ccgen_model *m)
{
    int does = m->event_values > 0;
    for (int i = 0; i < m->indicators; i++)
        does |= m->stops_at[i] > 0 || (m->joint_of && m->joint_of[i] >= 0);
    return does;
}

enum outcome make_simulation(struct ccgen_simulation *it, const struct ccgen_model *m,
                             const struct ccgen_settings *settings)
{
    it->phase = (struct phase){.s = &it->system, .run = &it->run};
    if (m->version != CCGEN_CONTRACT_VERSION)
        return OUTCOME_OTHER_CONTRACT;
    enum outcome outcome = make_run(&it->run, settings);
    if (!outcome)
        outcome = make_system(it, m, settings);
    if (outcome)
        return outcome;
    it->run.tolerance.unit = it->system.unit;
    it->run.tells = settings->events != CCGEN_IGNORE;
    it->run.watched = it->run.tells && m->indicators;
    it->run.acts = settings->events == CCGEN_ACT;
    it->run.halts =
        it->run.watched && (settings->events == CCGEN_HALT || (it->run.acts && (it->on_event || does_anything(m))));
    it->run.trace.of = TAKE(&it->arena, struct traced, TRACED_MOST);
    const int made = !take_phase(&it->phase) && (it->before = TAKE(&it->arena, char, kept_size(&it->phase)));
    return made ? OUTCOME_DONE : OUTCOME_NO_MEMORY;
}

enum outcome reserve_scratch(struct ccgen_simulation *it)
{
    return reserve(&it->arena, scratch_of(it->system.model)) ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
}

/* A window of the budget of steps and events begins. It is part of the state, for what goes on where it is spent depends on it. */
static void begin_window(struct run *run, double t)
{
    run->window = t;
    run->spent_before = run->steps + run->rejected + run->events;
}

static void clear_record(struct run *run)
{
    run->record.count = 0;
    run->record.told_from = run->record.told_to = NAN;
    run->impacts.count = run->impacts.contact_count = 0;
    run->modes.count = run->modes.contact_count = 0;
    run->stepping.count = 0;
    run->trace.count = run->trace.highest = 0;
    run->choices = 0;
}

/* How fast (1/s) the state in the phase moves, or begins to: whether it was interrupted meanwhile */
static int rate_of_start(struct phase *f, double *rate)
{
    struct system *s = f->s;
    const double baumgarte = s->baumgarte;
    s->baumgarte = 0.0; /* it damps by a time that is not known yet */
    const enum outcome outcome = evaluate_derivative(f);
    s->baumgarte = baumgarte;
    *rate = fastest(s, f->y + s->n);
    if (!outcome)
        *rate = fmax(*rate, sqrt(fastest(s, f->dy + s->n)));
    return outcome == OUTCOME_INTERRUPTED;
}

/* Motion begins from the state in the phase. */
static enum outcome begin_motion(struct ccgen_simulation *it)
{
    struct phase *f = &it->phase;
    struct run *run = &it->run;
    f->h = 0.0;
    f->at = (struct progress){0};
    f->branch.rank = 0;
    memset(f->branch.heading, 0, f->s->n * sizeof *f->branch.heading);
    if (f->branch.chart)
        forget_place(f->s, &f->branch);
    run->contact = -1;
    begin_window(run, f->t);
    clear_active_set(&f->active, it->system.model);
    memset(f->met, 0, it->system.model->contacts * sizeof *f->met);
    memset(f->tight, 0, it->system.model->contacts * sizeof *f->tight);
    forget_latches(f);
    start_automaton(&it->automaton);
    enum outcome outcome = project_position(&it->system, f->y);
    outcome = outcome ? outcome : project_velocity(&it->system, f->y, f->y + it->system.n);
    const int known = it->time > 0.0; /* a time of the mechanism: else how it begins tells one */
    const double longest = known ? it->time : run->duration;
    double rate = 0.0;
    if (!known && !outcome && rate_of_start(f, &rate))
        return OUTCOME_INTERRUPTED;
    const enum outcome scaled = set_scales(&it->system, longest, rate, f->y);
    if (outcome || scaled)
        return outcome ? outcome : scaled;
    note_speed(&it->automaton, f); /* before the first event too */
    return OUTCOME_DONE;
}

/* Begin at time t from the state in the phase. */
static enum outcome begin(struct ccgen_simulation *it, double t)
{
    struct run *run = &it->run;
    clear_record(run);
    it->phase.t = t;
    run->steps = run->rejected = run->events = 0;
    run->rest_speed = 0.0;
    return begin_motion(it);
}

enum outcome begin_anew(struct ccgen_simulation *it)
{
    struct phase *f = &it->phase;
    const size_t latches = it->system.model->latches;
    const int contacts = it->system.model->contacts;
    if (latches)
        memcpy(it->held, f->latched, latches * sizeof *it->held);
    enum outcome outcome = begin_motion(it);
    const struct mark mark = it->arena.top;
    signed char *none = TAKE(&it->arena, signed char, contacts); /* is held until it is chosen anew */
    if (it->arena.ran_out)
        outcome = OUTCOME_NO_MEMORY;
    else
        memset(none, OPEN, contacts);
    if (!outcome && append_modes(&it->run.modes, f->t, contacts, none))
        outcome = OUTCOME_NO_MEMORY;
    give_back(&it->arena, mark);
    outcome = outcome ? outcome : keep_latches(f, it->held);
    if (!outcome && append_row(&it->run.record, f->t, f->y, it->system.size, f->latched, latches))
        outcome = OUTCOME_NO_MEMORY; /* a row of its own, though only parameters may be others */
    return outcome;
}

enum outcome reset(struct ccgen_simulation *it, double t, const double *q, const double *u)
{
    const size_t n = it->system.n;
    double *y = it->phase.y;
    if (!all_finite(n, q) || !all_finite(n, u) || !all_finite(1, &t))
        return OUTCOME_NOT_FINITE;
    if (turned_far(&it->system, q))
        return OUTCOME_TURNED_FAR;
    forget_what_events_set(it);
    it->acted = 0;
    it->changes.count = it->changes.tried = 0;
    memset(y, 0, it->system.size * sizeof *y);
    memcpy(y, q, n * sizeof *y);
    memcpy(y + n, u, n * sizeof *y);
    const enum outcome outcome = begin(it, t);
    if (outcome)
        return outcome;
    return record_state(&it->phase) ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
}

struct recorded note_record(const struct run *run)
{
    const struct stepping *stepping = &run->stepping;
    struct recorded at = {.rows = run->record.count,
                          .impacts = run->impacts.count,
                          .struck = run->impacts.contact_count,
                          .modes = run->modes.count,
                          .held = run->modes.contact_count,
                          .stretches = stepping->count,
                          .choices = run->choices,
                          .traced = run->trace.count};
    if (at.stretches) {
        const size_t k = at.stretches - 1;
        at.last = stepping->last[k];
        at.t1 = stepping->t1[k];
        at.step = stepping->step[k];
        at.miss = stepping->miss[k];
    }
    return at;
}

void cut_record(struct run *run, struct recorded at)
{
    struct stepping *stepping = &run->stepping;
    run->record.count = at.rows;
    run->impacts.count = at.impacts;
    run->impacts.contact_count = at.struck;
    run->modes.count = at.modes;
    run->modes.contact_count = at.held;
    stepping->count = at.stretches;
    run->choices = at.choices;
    run->trace.count = at.traced;
    if (at.stretches) {
        const size_t k = at.stretches - 1;
        stepping->last[k] = at.last;
        stepping->t1[k] = at.t1;
        stepping->step[k] = at.step;
        stepping->miss[k] = at.miss;
    }
}

/* One stage of the automaton. One that is interrupted is as if it had not begun; of smooth motion the steps that were taken stay. */
static enum outcome run_whole_stage(struct ccgen_simulation *it)
{
    const struct recorded before = note_record(&it->run);
    if (has_action(&it->automaton))
        keep_state(&it->automaton, &it->phase, it->before);
    const enum outcome outcome = run_stage(&it->automaton, &it->phase);
    if (outcome == OUTCOME_INTERRUPTED && !it->phase.at.under_way) {
        take_back(&it->automaton, &it->phase, it->before);
        cut_record(&it->run, before);
    }
    return outcome;
}

enum outcome begin_call(struct ccgen_simulation *it, double until, int to_event, struct met *met)
{
    struct run *run = &it->run;
    const enum stage stage = it->automaton.stage;
    met->contact = stage != START && stage != MOVE && stage != END && it->automaton.event.contact >= 0;
    met->impacts = run->impacts.count;
    if (!run->record.count)
        return OUTCOME_NOT_BEGUN;
    if (!(until >= it->phase.t))
        return OUTCOME_BAD_SETTINGS;
    run->until = until;
    run->contact = -1;
    run->taken_before = run->paced_from = run->steps + run->rejected;
    run->paced_since = it->phase.t;
    run->paced =
        !to_event && run->fixed_step == 0.0; /* steps of fixed length keep their pace, and events may be near */
    start_asking(&run->interruption, it->phase.t);
    it->system.interruption = &run->interruption;
    return OUTCOME_DONE;
}

enum outcome go_on_by_a_stage(struct ccgen_simulation *it, struct met *met)
{
    struct run *run = &it->run;
    const enum stage *stage = &it->automaton.stage;
    if (*stage == STEP) /* what was met is left behind */
        met->contact = 0;
    if (*stage == MEET) {
        met->impacts = run->impacts.count;
        met->contact = 1;
    }
    const size_t before = run->impacts.count;
    const enum outcome outcome = run_whole_stage(it);
    if (*stage == STRIKE && it->automaton.event.watch == JAMS && !met->contact) {
        met->impacts = before;
        met->contact = 1;
    }
    return outcome;
}

enum outcome record_end(struct ccgen_simulation *it, enum outcome outcome)
{
    const struct record *record = &it->run.record;
    const int later = it->phase.t > record->t[record->count - 1];
    return later && record_state(&it->phase) ? OUTCOME_NO_MEMORY : outcome;
}

enum outcome end_call(struct ccgen_simulation *it, enum outcome outcome)
{
    it->system.interruption = NULL;
    return it->run.outcome = record_end(it, outcome);
}

void ccgen_get_motion(const struct ccgen_simulation *it, double *t, double *q, double *u)
{
    const size_t n = it->system.n;
    if (t)
        *t = it->phase.t;
    if (q)
        memcpy(q, it->phase.y, n * sizeof *q);
    if (u)
        memcpy(u, it->phase.y + n, n * sizeof *u);
}

const double *ccgen_get_constants(const struct ccgen_simulation *it)
{
    return it->system.k;
}

const double *ccgen_get_parameters(const struct ccgen_simulation *it)
{
    return it->run.values;
}

void ccgen_get_modes(const struct ccgen_simulation *it, signed char *modes)
{
    contact_modes(&it->phase.active, it->system.model->contacts, modes);
}

size_t ccgen_state_size(const struct ccgen_simulation *it)
{
    return state_size(&it->phase);
}

void ccgen_get_state(const struct ccgen_simulation *it, void *bytes)
{
    get_state(&it->automaton, &it->phase, bytes);
    seal_state(bytes, state_size(&it->phase));
}

enum outcome begin_record(struct ccgen_simulation *it)
{
    struct run *run = &it->run;
    const struct phase *f = &it->phase;
    clear_record(run);
    if (record_state(&it->phase))
        return OUTCOME_NO_MEMORY;
    signed char *modes = (signed char *)it->before; /* one for each contact: less than a state takes */
    ccgen_get_modes(it, modes);
    const int contacts = it->system.model->contacts;
    return append_modes(&run->modes, f->t, contacts, modes) ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
}

size_t ccgen_rows(const struct ccgen_simulation *it, const double **t, const double **rows, size_t *width)
{
    *t = it->run.record.t;
    *rows = it->run.record.y;
    *width = row_width(&it->system);
    return it->run.record.count;
}

const char *ccgen_outcome_name(int code)
{
#define NAMED(name, text) text,
    static const char *const names[] = {ALL_OUTCOMES(NAMED)};
#undef NAMED
    return code >= 0 && code < OUTCOMES ? names[code] : "no outcome";
}

const char *ccgen_mode_name(int mode)
{
#define NAMED(name, number, text) \
    case name:                    \
        return text;
    switch (mode) {
        ALL_CONTACT_MODES(NAMED)
    }
#undef NAMED
    return NULL;
}

const char *ccgen_drift_name(int drift)
{
#define NAMED(name, text) text,
    static const char *const names[] = {ALL_DRIFTS(NAMED)};
#undef NAMED
    return drift >= 0 && drift < DRIFTS ? names[drift] : NULL;
}

const char *ccgen_gain_name(int gain)
{
#define NAMED(name, text) text,
    static const char *const names[] = {ALL_GAINS(NAMED)};
#undef NAMED
    return gain >= 0 && gain < GAINS ? names[gain] : NULL;
}
