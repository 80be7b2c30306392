/* The calls of ../../ccgen.h by which a simulation begins, goes on and ends, with the events of its scene. */
#include "interface/calls.h"

#include "hybrid/state.h"
#include "interface/acting.h"
#include "interface/changes.h"
#include "interface/crossings.h"
#include "interface/halting.h"

int ccgen_create(const struct ccgen_model *model, const struct ccgen_settings *settings,
                 struct ccgen_simulation **simulation)
{
    struct ccgen_simulation *it = *simulation = calloc(1, sizeof *it);
    enum outcome outcome = it ? make_simulation(it, model, settings) : OUTCOME_NO_MEMORY;
    if (!outcome && it->run.watched && take_watch(it))
        outcome = OUTCOME_NO_MEMORY;
    outcome = outcome ? outcome : reserve_scratch(it);
    if (outcome) {
        ccgen_destroy(it);
        *simulation = NULL;
    }
    return outcome;
}

void ccgen_destroy(struct ccgen_simulation *it)
{
    if (!it)
        return;
    free_run(&it->run);
    free_watch(it);
    free_changes(it);
    free_arena(&it->arena);
    free(it);
}

int ccgen_reset(struct ccgen_simulation *it, double t, const double *q, const double *u)
{
    const enum outcome outcome = reset(it, t, q, u);
    if (!outcome)
        watch_from_start(it);
    return outcome;
}

/* Go on to `until`, or only past the next event. */
static enum outcome go_on(struct ccgen_simulation *it, double until, int to_event, struct met *met)
{
    const enum stage *stage = &it->automaton.stage;
    enum outcome outcome = begin_call(it, until, to_event, met);
    if (outcome)
        return outcome;
    do
        outcome = go_on_by_a_stage(it, met);
    while (!outcome && *stage != END && !(to_event && met->contact && *stage == MOVE));
    return end_call(it, outcome);
}

enum outcome simulate(struct ccgen_simulation *it, double until, int *halts)
{
    struct met met = {.indicator = -1};
    const enum outcome outcome = it->run.halts ? go_on_to_crossing(it, until, 0, &met) : go_on(it, until, 0, &met);
    *halts = met.indicator >= 0;
    return outcome;
}

enum outcome simulate_through_events(struct ccgen_simulation *it, double until, int *ends)
{
    int acts = 1;
    enum outcome outcome = OUTCOME_DONE;
    *ends = 0;
    while (acts && !outcome && !*ends) {
        outcome = simulate(it, until, &acts);
        if (acts && !outcome)
            outcome = act(it, ends);
    }
    return outcome;
}

int ccgen_step_to_event(struct ccgen_simulation *it, double until, struct ccgen_event *event)
{
    struct met met = {.indicator = -1};
    int ends = 0;
    enum outcome outcome = it->run.halts ? go_on_to_crossing(it, until, 1, &met) : go_on(it, until, 1, &met);
    const struct event *found = &it->automaton.event;
    *event = (struct ccgen_event){CCGEN_NO_EVENT, it->phase.t, -1, it->run.impacts.count - met.impacts, met.indicator};
    if (met.contact && !outcome) {
        event->contact = found->contact;
        event->kind = found->watch == CLOSES ? CCGEN_CLOSES : found->watch == JAMS ? CCGEN_JAMS : CCGEN_CHANGES;
    }
    if (met.indicator >= 0 && !outcome)
        event->kind = CCGEN_CROSSES;
    if (event->kind == CCGEN_CROSSES && it->run.acts) {
        outcome = act(it, &ends);
        event->impacts = it->run.impacts.count - met.impacts; /* with those of joints that took hold */
    }
    if (outcome == OUTCOME_INTERRUPTED) /* also where the program breaks off what it is asked: before the event */
        *event = (struct ccgen_event){CCGEN_NO_EVENT, it->phase.t, -1, 0, -1};
    else if (ends && !outcome)
        event->kind = CCGEN_ENDS;
    return outcome;
}

int ccgen_set_state(struct ccgen_simulation *it, const void *bytes)
{
    keep_state(&it->automaton, &it->phase, it->before);
    const int wrong = !is_whole(bytes, state_size(&it->phase)) || set_state(&it->automaton, &it->phase, bytes);
    if (wrong) {
        take_back(&it->automaton, &it->phase, it->before);
        return OUTCOME_OTHER_STATE;
    }
    if (it->run.acts) {
        derive_parameters(it);
        it->changed = 1;
    }
    begin_watch(it);
    forget_changes(it);
    return begin_record(it);
}

int ccgen_forget(struct ccgen_simulation *it)
{
    if (!it->run.record.count)
        return OUTCOME_NOT_BEGUN;
    const enum outcome outcome = it->watch ? look_at_all(it) : OUTCOME_DONE;
    if (outcome)
        return outcome;
    forget_rows_looked_at(it);
    forget_changes(it);
    it->leg.goes_on = 0; /* what is forgotten is not gone back to */
    return begin_record(it);
}
