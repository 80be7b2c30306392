/* What events of the scene do where a run halts at them (docs/theory, section 5.17).
 *
 * All that come at one instant are done together, in the order of their tables, with values that are worked out before any is set; behind them joints that change, one after
 * the other, for each that takes hold has an impact of its own. Motion then begins anew from there. Effects hold what they held, but those that come on. The scales of the
 * mechanism stay those with which the simulation was made. */
#include "interface/acting.h"

#include <math.h>
#include <string.h>

#include "base/tolerances.h"
#include "base/within.h"
#include "hybrid/state.h"
#include "interface/crossings.h"
#include "interface/joint_changes.h"
#include "model/contacts.h"

enum { MOST_ACTS = 10000 /* of a run; more are taken for a parameter that is set to and fro without end */ };

static int may_be(enum ccgen_domain domain, double value)
{
    if (domain == CCGEN_POSITIVE)
        return value > 0.0 && isfinite(value);
    if (domain == CCGEN_FROM_0_TO_1 || domain == CCGEN_OFF_OR_ON)
        return value >= 0.0 && value <= 1.0;
    return isfinite(value) && (domain == CCGEN_ANY || value >= 0.0);
}

/* Set what event i does; 1 where that cannot be. *sets is whether it has: what is on already is not switched on. */
static int set_values_of(struct ccgen_simulation *it, int i, int *sets)
{
    const struct ccgen_model *m = it->system.model;
    for (int j = 0; j < m->event_values; j++) {
        const int to = m->value_to[j];
        const enum ccgen_domain within = (enum ccgen_domain)m->value_within[j];
        const double value = it->event_values[j];
        if (m->value_of[j] != i || (to >= 0 && within == CCGEN_OFF_OR_ON && it->run.values[to] == value))
            continue;
        *sets = 1;
        if (to < 0 || !may_be(within, value))
            return 1;
        it->run.values[to] = value;
    }
    return 0;
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

/* Set what has come at this instant: events, then joints, which read what those have set. */
static enum outcome do_what_came(struct ccgen_simulation *it, int *sets, int *ends)
{
    const struct ccgen_model *m = it->system.model;
    enum outcome outcome = OUTCOME_DONE;
    int wrong = 0;
    for (int i = 0; i < m->indicators; i++) {
        if (!times_come(it, i, ends) || outcome)
            continue;
        if (!is_of_joint(it, i)) {
            wrong |= set_values_of(it, i, sets);
            continue;
        }
        if (*sets && !wrong)
            derive_parameters(it);
        *sets = 1;
        outcome = wrong ? OUTCOME_CANNOT_SET : change_joint(it, i);
    }
    if (*sets)
        derive_parameters(it);
    return wrong ? OUTCOME_CANNOT_SET : outcome;
}

enum outcome act(struct ccgen_simulation *it, int *ends)
{
    const struct ccgen_model *m = it->system.model;
    const double *y = it->phase.y, *u = y + it->system.n;
    const struct recorded before = note_record(&it->run);
    int sets = 0;
    *ends = 0;
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
    if (outcome) { /* nothing has been set then */
        take_back(&it->automaton, &it->phase, it->before);
        cut_record(&it->run, before);
        derive_parameters(it);
    } else
        watch_anew(it);
    return it->run.outcome = outcome;
}
