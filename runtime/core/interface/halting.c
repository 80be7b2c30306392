/* Motion up to events of the scene.
 *
 * A run goes leg by leg: it pauses before each step that may hold an event, takes that step alone, and is looked at then; so is what impacts and time stepping do at
 * the end of a leg. Where an event lies in a leg the state before it is put back, and motion goes on to the event: so the instant is found in a step of the
 * run, and the run has a row there. Where it is interrupted in a leg with an event, or on the way back to that, the leg is undone. Who goes on then does so by
 * legs of one step, and is asked nothing on the way back: so every call gets on, however often its tick interrupts, if one step does.
 */
#include "interface/halting.h"

#include <math.h>

#include "base/tolerances.h"
#include "hybrid/state.h"
#include "interface/between.h"
#include "interface/changes.h"
#include "interface/crossings.h"

enum {
    STEPS_OF_A_LEG = 64, /* of time stepping, which ends at no event by itself */
    CORRECTIONS = 8      /* of the instant at which a run ends */
};

/* Stages until smooth motion has gone on as far as it does, and what it meets is dealt with */
static enum outcome go_on_by_a_leg(struct ccgen_simulation *it, struct met *met)
{
    const enum stage *stage = &it->automaton.stage;
    enum outcome outcome;
    int rested;
    it->run.paused = 0;
    do {
        rested = *stage == END;
        outcome = go_on_by_a_stage(it, met);
    } while (!outcome && *stage != END && (*stage != MOVE || rested));
    return outcome;
}

static void begin_leg(struct ccgen_simulation *it, const struct met *met)
{
    struct leg *leg = &it->leg;
    leg->state = begin_halting(it);
    keep_state(&it->automaton, &it->phase, leg->state);
    leg->at = note_record(&it->run);
    leg->met = *met;
    keep_watch(it);
}

static void undo_leg(struct ccgen_simulation *it)
{
    take_back(&it->automaton, &it->phase, it->leg.state);
    cut_record(&it->run, it->leg.at);
}

void go_before_halt(struct ccgen_simulation *it)
{
    undo_leg(it);
    restore_watch(it);
    if (it->run.acts) {
        cut_changes(it, it->leg.at.rows);
        derive_parameters(it);
    }
    it->broken_off = 1;
}

/* Back to where a leg began, and on to an instant within it */
static enum outcome go_on_to(struct ccgen_simulation *it, double t, struct met *met)
{
    enum outcome outcome;
    undo_leg(it);
    *met = it->leg.met;
    it->run.until = t;
    do
        outcome = go_on_by_a_stage(it, met);
    while (!outcome && (it->automaton.stage != END || it->phase.t < t));
    return outcome;
}

/* Back to where the last leg began, and on to the event that lies in it. The step that ends there ends a little before or behind what the whole step has there; or, by time
 * stepping, before the impact that it has, and then the whole step is taken, if the event comes by that. */
static enum outcome go_on_to_halt(struct ccgen_simulation *it, struct halt halt, struct met *met)
{
    double t = halt.t, more;
    const int by_steps = stepped_at(it, t);
    enum outcome outcome = go_on_to(it, t, met);
    for (int k = 0; k < CORRECTIONS && !outcome && t < halt.latest && (more = ldexp(short_of_halt(it), k)) > 0.0; k++)
        outcome = go_on_to(it, t = fmin(t + more, halt.latest), met);
    if (!outcome && by_steps && short_of_halt(it) > 0.0)
        outcome = go_on_to(it, halt.latest, met);
    if (!outcome && by_steps &&
        short_of_halt(it) > 0.0) /* it comes to zero in the whole step alone, by less than that is wrong */
        outcome = go_on_to(it, halt.t, met);
    return outcome;
}

/* The first time from t on that a double has, which callers that act themselves go on from */
static double round_up_to_double(double t)
{
    int exponent;
    const double scaled = ldexp(frexp(t, &exponent), 53);
    int64_t whole = (int64_t)scaled;
    whole += (double)whole < scaled;
    return ldexp((double)whole, exponent - 53);
}

enum outcome go_on_to_crossing(struct ccgen_simulation *it, double until, int to_event, struct met *met)
{
    struct run *run = &it->run;
    const enum stage *stage = &it->automaton.stage;
    struct halt halt = {INFINITY, INFINITY, -1};
    int legs = 0;
    enum outcome outcome = begin_call(it, until, to_event, met);
    met->indicator = -1;
    if (outcome)
        return outcome;
    if (!it->leg.goes_on || to_event) /* what a call has told is not gone back before */
        begin_leg(it, met);
    it->leg.goes_on = 0;
    outcome = find_halt(it, &halt);
    run->pauses = GOES_ON;
    while (!outcome && halt.indicator < 0 && (*stage != END || it->phase.t < until) &&
           !(legs && to_event && met->contact && *stage == MOVE)) {
        run->pauses = run->paused && run->pauses == BEFORE_EVENTS ? BEHIND_A_STEP : BEFORE_EVENTS;
        begin_leg(it, met);
        legs++;
        const int steps = it->broken_off ? 1 : STEPS_OF_A_LEG;
        run->until = run->method->order ? until : fmin(until, it->phase.t + steps * run->fixed_step);
        outcome = record_end(it, go_on_by_a_leg(it, met));
        if (outcome != OUTCOME_INTERRUPTED) {
            const enum outcome looked = find_halt(it, &halt);
            outcome = outcome ? outcome : looked;
        }
    }
    run->pauses = GOES_ON;
    run->paused = 0;
    if (outcome == OUTCOME_INTERRUPTED) { /* what is kept has no event at which it should have ended */
        start_asking(&run->interruption, it->phase.t);
        if ((find_halt(it, &halt) || halt.indicator >= 0) && legs) {
            *met = it->leg.met;
            go_before_halt(it);
        }
        halt.indicator = -1;
    } else if (halt.indicator >= 0) { /* what failed does so behind it */
        int (*const tick)(void *, double) = run->interruption.tick;
        outcome = OUTCOME_DONE;
        if (it->broken_off)
            run->interruption.tick = NULL;
        if (legs && halt.t < it->phase.t)
            outcome = go_on_to_halt(it, halt, met);
        run->until = run->acts ? it->phase.t : round_up_to_double(it->phase.t);
        while (!outcome && it->phase.t < run->until)
            outcome = go_on_by_a_stage(it, met);
        run->interruption.tick = tick;
        it->broken_off = outcome == OUTCOME_INTERRUPTED;
        if (outcome && legs)
            restore_watch(it);
    }
    outcome = end_call(it, outcome);
    met->indicator = outcome ? -1 : halt.indicator;
    if (met->indicator >= 0)
        end_at_halt(it, TOGETHER * fmax(fabs(halt.t), run->duration));
    return outcome;
}
