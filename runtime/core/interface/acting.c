/* What events of the scene do where a run halts at them (docs/theory, section 5.17).
 *
 * All that come at one instant are done together, in the order of their tables, with values that are worked out before any is set; the program's own answer to an event is asked
 * for behind what the scene says of it. Joints that change do so one after the other, for each that takes hold has an impact of its own. Motion then begins anew from there. Effects hold what they held, but those that come on. The scales of the
 * mechanism stay those with which the simulation was made. */
#include "interface/acting.h"

#include <math.h>
#include <string.h>

#include "base/tolerances.h"
#include "base/within.h"
#include "hybrid/state.h"
#include "interface/changes.h"
#include "interface/crossings.h"
#include "interface/halting.h"
#include "interface/joint_changes.h"
#include "model/contacts.h"

enum { MOST_ACTS = 10000 /* of a run; more are taken for a parameter that is set to and fro without end */ };

/* What is set has the digits of a double, also in numbers that are wider: so it is the same number wherever it is told. */
static double nearest_double(double value)
{
    int exponent;
    const double part = frexp(value, &exponent);
    if (!isfinite(value))
        return value;
    double scaled = ldexp(part, 53), whole = (double)(int64_t)scaled; /* towards zero */
    const double rest = fabs(scaled - whole);
    if (rest > 0.5 || (rest == 0.5 && (int64_t)scaled % 2))
        whole += copysign(1.0, scaled);
    return ldexp(whole, exponent - 53);
}

static int may_be(enum ccgen_domain domain, double value)
{
    if (domain == CCGEN_POSITIVE)
        return value > 0.0 && isfinite(value);
    if (domain == CCGEN_FROM_0_TO_1 || domain == CCGEN_OFF_OR_ON)
        return value >= 0.0 && value <= 1.0;
    return isfinite(value) && (domain == CCGEN_ANY || value >= 0.0);
}

/* Write what event i sets. What is on already is not switched on. Whether it sets something */
static int set_values_of(struct ccgen_simulation *it, int i)
{
    const struct ccgen_model *m = it->system.model;
    int sets = 0;
    for (int j = 0; j < m->event_values; j++) {
        const int to = m->value_to[j];
        const double value = it->event_values[j];
        if (m->value_of[j] != i || (to >= 0 && m->value_within[j] == CCGEN_OFF_OR_ON && it->run.values[to] == value))
            continue;
        sets = 1;
        if (to >= 0)
            it->run.values[to] = nearest_double(value);
    }
    return sets;
}

/* Whether that can be, where the program has not written others */
static int may_be_set(const struct ccgen_simulation *it, int i)
{
    const struct ccgen_model *m = it->system.model;
    int may = 1;
    for (int j = 0; j < m->event_values; j++) {
        const int to = m->value_to[j];
        if (m->value_of[j] != i)
            continue;
        const double now = to < 0 ? NAN : it->run.values[to];
        may &= (now != nearest_double(it->event_values[j]) && !isnan(now)) ||
               may_be((enum ccgen_domain)m->value_within[j], now);
    }
    return may;
}

/* What the program answers to an event, having written what it wants set */
static int ask_program(struct ccgen_simulation *it, const struct ccgen_crossing *event)
{
    const double *y = it->phase.y;
    if (!it->on_event || (it->answered && !it->answered[event->indicator]))
        return CCGEN_GO_ON;
    return it->on_event(it->event_context, event, y, y + it->system.n, it->run.values);
}

static double energy_of(const struct ccgen_simulation *it)
{
    double energy[2];
    it->system.model->energy(it->k, it->phase.y, it->phase.y + it->system.n, energy);
    return energy[0] + energy[1];
}

/* Joints whose gates an event wants to be what they were not let go or take hold. One that has broken meanwhile stays so. */
static enum outcome change_joints(struct ccgen_simulation *it, int *sets)
{
    const struct ccgen_model *m = it->system.model;
    enum outcome outcome = OUTCOME_DONE;
    for (int i = 0; i < m->indicators && !outcome; i++) {
        const int gate = is_of_joint(it, i) ? m->gate_of[i] : -1;
        if (gate < 0 || it->wanted[gate] == it->was[gate])
            continue;
        it->was[gate] = it->wanted[gate];
        if (it->run.values[gate] != it->wanted[gate]) {
            *sets = 1;
            outcome = change_gate(it, gate, it->wanted[gate]);
        }
    }
    return outcome;
}

/* What one event does: it sets what the scene says, then what the program answers; then joints let go and take hold. */
static enum outcome do_event(struct ccgen_simulation *it, const struct ccgen_crossing *event, int *sets, int *ends)
{
    const struct ccgen_model *m = it->system.model;
    const size_t size = m->parameters * sizeof *it->wanted;
    const double before = energy_of(it);
    double *values = it->run.values, *was = it->was;
    memcpy(was, values, size);
    int mine = set_values_of(it, event->indicator);
    int answer = ask_program(it, event);
    if (answer != CCGEN_GO_ON && answer != CCGEN_END && answer != CCGEN_REFUSE) {
        *sets = 1;
        return OUTCOME_INTERRUPTED;
    }
    answer = may_be_set(it, event->indicator) ? answer : CCGEN_REFUSE;
    memcpy(it->wanted, values, size);
    for (int i = 0; i < m->indicators; i++) /* joints change one by one, behind this */
        if (is_of_joint(it, i))
            values[m->gate_of[i]] = was[m->gate_of[i]];
    for (int i = 0; i < m->parameters; i++)
        mine |= values[i] != was[i];
    const int stops = stops_motion(it, event->indicator);
    *ends |= stops || answer == CCGEN_END;
    if (mine || answer == CCGEN_REFUSE) {
        *sets = 1;
        derive_parameters(it);
        struct ccgen_change *change = try_change(it, event->indicator, -1);
        if (!change)
            return OUTCOME_NO_MEMORY;
        change->energy = energy_of(it) - before;
    }
    return answer == CCGEN_REFUSE ? OUTCOME_CANNOT_SET : change_joints(it, sets);
}

/* Effects that were off and come on hold nothing yet. */
static void forget_what_was_off(struct ccgen_simulation *it)
{
    const struct ccgen_model *m = it->system.model;
    for (int j = 0; j < m->event_values; j++) {
        const int to = m->value_to[j], *forgets = m->value_forgets + 2 * j;
        for (int k = 0; k < forgets[1] && it->run.values[to] > it->kept[to]; k++)
            it->phase.latched[forgets[0] + k] = NAN;
    }
}

/* Whether the state is one that motion can begin from */
static enum outcome check_state(struct ccgen_simulation *it)
{
    struct system *s = &it->system;
    const struct ccgen_model *m = s->model;
    struct arena *arena = s->arena;
    const struct mark mark = arena->top;
    double *miss = TAKE(arena, double, m->rows + (size_t)m->contacts), *gaps = miss + m->rows;
    enum outcome outcome = arena->ran_out ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    if (!outcome && !all_finite(m->constants, s->k))
        outcome = OUTCOME_CANNOT_SET;
    if (!outcome && m->rows) {
        m->closure(s->k, it->phase.y, miss);
        for (int i = 0; i < m->rows; i++)
            outcome = fabs(miss[i]) <= LOOPS_OPEN * s->length ? outcome : OUTCOME_OPENED;
    }
    if (!outcome && m->contacts) {
        contact_gaps(s, it->phase.y, gaps);
        for (int c = 0; c < m->contacts && !outcome; c++)
            if (!(-gaps[c] <= BEHIND * s->length)) {
                it->run.contact = c;
                outcome = OUTCOME_INSIDE;
            }
    }
    give_back(arena, mark);
    return outcome;
}

/* What comes at this instant: events, then joints, which read what those have set */
static enum outcome do_what_came(struct ccgen_simulation *it, int *sets, int *ends)
{
    size_t count;
    const struct ccgen_crossing *came = crossings_of_instant(it, &it->crossing, &count);
    enum outcome outcome = OUTCOME_DONE;
    for (size_t k = 0; k < count && !outcome; k++, it->crossing++) {
        const int i = came[k].indicator;
        outcome = is_of_joint(it, i) ? change_joint(it, i, sets) : do_event(it, &came[k], sets, ends);
    }
    return outcome;
}

enum outcome act(struct ccgen_simulation *it, int *ends)
{
    const struct ccgen_model *m = it->system.model;
    const double *y = it->phase.y, *u = y + it->system.n;
    const struct recorded before = note_record(&it->run);
    int sets = 0;
    *ends = 0;
    it->changes.tried = it->changes.count;
    if (m->event_values)
        m->find_event_values(it->k, y, u, it->phase.t, it->event_values);
    if (m->parameters)
        memcpy(it->kept, it->run.values, m->parameters * sizeof *it->kept);
    keep_state(&it->automaton, &it->phase, it->before);
    enum outcome outcome = do_what_came(it, &sets, ends);
    if (!sets)
        return OUTCOME_DONE;
    it->changed = 1;
    outcome = outcome ? outcome : check_state(it);
    if (!outcome && ++it->acted > MOST_ACTS)
        outcome = OUTCOME_SET_WITHOUT_END;
    if (!outcome) {
        forget_what_was_off(it);
        outcome = begin_anew(it);
    }
    if (!outcome) {
        keep_changes(it, before);
        it->leg.goes_on = 1;
        watch_anew(it);
    } else { /* nothing has been set then */
        take_back(&it->automaton, &it->phase, it->before);
        cut_record(&it->run, before);
        derive_parameters(it);
        if (outcome == OUTCOME_INTERRUPTED)
            go_before_halt(it);
    }
    return it->run.outcome = outcome;
}
