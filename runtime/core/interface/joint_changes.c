/* Joints that let go and take hold: what is compared with their limits, and the impact by which they take hold.
 *
 * The rows of such a joint are on while its gate is 1. Where it comes on, the velocities change by the impulses of its rows alone, as loops that are shut stay so and drives
 * go on: a projection onto the rates of all rows that are on, in the metric of the masses (docs/theory, eq. 5.26). Contacts have no part in that; motion begins anew behind it.
 */
#include "interface/joint_changes.h"

#include <math.h>
#include <string.h>

#include "base/tolerances.h"
#include "interface/changes.h"
#include "interface/forces.h"
#include "motion/projection.h"

enum { BY_TIME, BY_FORCE, BY_MEETING }; /* as the contract's change_by has them */

enum limit { OF_FORCE, OF_IMPULSE, OF_DISTANCE, LIMITS };

static double limit_of(const struct ccgen_model *m, int i, enum limit which)
{
    return m->limits[LIMITS * i + which];
}

static int is_change(const struct ccgen_model *m, int i)
{
    return m->joint_of && m->joint_of[i] >= 0;
}

/* Whether the rows behind a gate are on */
static int holds(const struct system *s, int gate)
{
    for (int k = 0; k < s->rows_on; k++)
        if (s->model->row_held[s->on[k]] == gate)
            return 1;
    return 0;
}

int is_looked_for(const struct ccgen_simulation *it, int i)
{
    const struct ccgen_model *m = it->system.model;
    return !is_change(m, i) || holds(&it->system, m->gate_of[i]) == m->held_before[i];
}

static int comes_by(const struct ccgen_simulation *it, int i, int by)
{
    const struct ccgen_model *m = it->system.model;
    return is_change(m, i) && m->change_by[i] == by && is_looked_for(it, i);
}

int is_of_force(const struct ccgen_simulation *it, int i)
{
    return comes_by(it, i, BY_FORCE);
}

int is_of_time(const struct ccgen_simulation *it, int i)
{
    return comes_by(it, i, BY_TIME);
}

enum outcome compare_forces(const struct ccgen_simulation *it, struct between *b, double t, int before, const double *q,
                            const double *u, double *value)
{
    const struct ccgen_model *m = it->system.model;
    int some = 0;
    for (int i = 0; i < m->indicators; i++)
        some |= is_of_force(it, i);
    if (!some)
        return OUTCOME_DONE;
    struct system s = it->system;
    struct arena *arena = s.arena;
    const struct mark mark = arena->top;
    double *u_dot = TAKE(arena, double, s.n), *lambda = TAKE(arena, double, m->rows + 1);
    double *push = TAKE(arena, double, 2 * (size_t)m->contacts), *reaction = TAKE(arena, double, 3 * (size_t)m->joints);
    double *told = TAKE(arena, double, m->told);
    struct obstruction found;
    char unknown = 0;
    enum outcome outcome = arena->ran_out ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    if (!outcome) {
        s.interruption = NULL;
        held_at(it, b, before ? nextafter(t, -INFINITY) : t, 1);
        latched_at(it, b, t);
        const struct held held = {b->count, b->set, b->mode, 0};
        const enum outcome known = held_forces(&s, 1, 1, &t, q, u, m->latches ? b->latched : NULL, held, u_dot, lambda,
                                               push, reaction, told, &unknown, &found);
        unknown |= known != OUTCOME_DONE || found.why != OBSTACLE_NONE;
        outcome = known == OUTCOME_NO_MEMORY ? known : OUTCOME_DONE;
    }
    for (int i = 0; i < m->indicators && !outcome; i++)
        if (is_of_force(it, i)) {
            const double *of = reaction + 3 * (size_t)m->joint_of[i];
            value[i] = unknown ? NAN : hypot(of[0], of[1]) - limit_of(m, i, OF_FORCE);
        }
    give_back(arena, mark);
    return outcome;
}

enum outcome find_impulse(const struct ccgen_simulation *it, size_t impact, int i, int *passed)
{
    const struct ccgen_model *m = it->system.model;
    const struct impacts *impacts = &it->run.impacts;
    *passed = 0;
    if (!is_change(m, i) || !(limit_of(m, i, OF_IMPULSE) > 0.0) || !is_looked_for(it, i))
        return OUTCOME_DONE;
    struct system s = it->system;
    struct arena *arena = s.arena;
    const struct mark mark = arena->top;
    const size_t n = s.n, width = s.size + (size_t)m->latches;
    double *du = TAKE(arena, double, n), *P = TAKE_ZEROS(arena, double, 2 * (size_t)m->contacts);
    double *reaction = TAKE(arena, double, 3 * (size_t)m->joints);
    enum outcome outcome = arena->ran_out ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    if (!outcome) {
        for (size_t j = 0; j < n; j++)
            du[j] = impacts->u_plus[impact * n + j] - impacts->u_minus[impact * n + j];
        for (size_t k = impacts->first[impact]; k < impacts->first[impact + 1]; k++) {
            P[impacts->contact[k]] += impacts->impulse[k];
            P[m->contacts + impacts->contact[k]] += impacts->friction[k];
        }
        outcome = joint_impulses(&s, it->run.record.y + impacts->after[impact] * width, du, P, reaction);
    }
    if (!outcome) {
        const double *of = reaction + 3 * (size_t)m->joint_of[i];
        *passed = hypot(of[0], of[1]) >= limit_of(m, i, OF_IMPULSE);
    }
    give_back(arena, mark);
    return outcome;
}

/* How far (m) the points of the joint behind a gate are apart at q; rows[rows] is scratch. */
static double distance(const struct ccgen_simulation *it, int gate, const double *q, double *rows)
{
    const struct ccgen_model *m = it->system.model;
    double square = 0.0;
    m->closure(it->k_held, q, rows);
    for (int r = 0; r < m->rows; r++)
        square += m->row_held[r] == gate ? rows[r] * rows[r] : 0.0;
    return sqrt(square);
}

/* How far they may be for it to take hold by indicator i, or, -1, by none */
static double farthest(const struct ccgen_simulation *it, int i)
{
    const double within = i < 0 ? 0.0 : limit_of(it->system.model, i, OF_DISTANCE);
    return within > 0.0 ? within : HOLDS_WITHIN * it->system.length;
}

int is_near(const struct ccgen_simulation *it, int i, const double *q)
{
    struct arena *arena = it->system.arena;
    const struct mark mark = arena->top;
    double *rows = TAKE(arena, double, it->system.model->rows);
    const int near = !comes_by(it, i, BY_MEETING) ||
                     (!arena->ran_out && distance(it, it->system.model->gate_of[i], q, rows) <= farthest(it, i));
    give_back(arena, mark);
    return near;
}

/* Joints that hold with these impulses, which are more than their limits, let go. */
static enum outcome break_joints(struct ccgen_simulation *it, const double *reaction)
{
    const struct ccgen_model *m = it->system.model;
    for (int i = 0; i < m->indicators; i++) {
        if (!is_change(m, i) || !m->held_before[i] || !(limit_of(m, i, OF_IMPULSE) > 0.0) ||
            it->run.values[m->gate_of[i]] == 0.0)
            continue;
        const double *of = reaction + 3 * (size_t)m->joint_of[i];
        if (!(hypot(of[0], of[1]) >= limit_of(m, i, OF_IMPULSE)))
            continue;
        it->run.values[m->gate_of[i]] = 0.0;
        if (!try_change(it, i, m->gate_of[i]))
            return OUTCOME_NO_MEMORY;
    }
    derive_parameters(it);
    return OUTCOME_DONE;
}

static double energy_at(const struct system *s, const double *q, const double *u)
{
    double energy[2];
    s->model->energy(s->k, q, u, energy);
    return energy[0] + energy[1];
}

/* The impact by which the joint behind a gate takes hold, by indicator i or by none. Its gate is on. */
static enum outcome take_hold(struct ccgen_simulation *it, int gate, int i, struct ccgen_change *change)
{
    const struct ccgen_model *m = it->system.model;
    struct system s = it->system;
    struct arena *arena = s.arena;
    const struct mark mark = arena->top;
    const size_t n = s.n;
    double *q = it->phase.y, *u = q + n, *was = TAKE(arena, double, n), *du = TAKE(arena, double, n);
    double *P = TAKE_ZEROS(arena, double, 2 * (size_t)m->contacts), *rows = TAKE(arena, double, m->rows);
    double *reaction = TAKE(arena, double, 3 * (size_t)m->joints), energy[2], left[2];
    enum outcome outcome = arena->ran_out ? OUTCOME_NO_MEMORY : OUTCOME_DONE;
    if (outcome)
        goto end;
    change->gap = distance(it, gate, q, rows);
    outcome = change->gap <= farthest(it, i) ? OUTCOME_DONE : OUTCOME_TOO_FAR;
    if (outcome)
        goto end;
    s.active = NULL;
    s.branch = NULL;
    memcpy(was, u, n * sizeof *u);
    m->energy(s.k, q, u, energy);
    outcome = project_velocity(&s, q, u);
    if (outcome)
        goto end;
    m->energy(s.k, q, u, left);
    for (size_t j = 0; j < n; j++)
        du[j] = u[j] - was[j];
    outcome = joint_impulses(&s, q, du, P, reaction);
    if (!outcome && append_impact(&it->run.impacts, it->phase.t, was, u, n, 0, NULL, NULL, energy[0] - left[0], 1.0,
                                  it->run.record.count))
        outcome = OUTCOME_NO_MEMORY;
    outcome = outcome ? outcome : project_state(&s, q, u);
    if (!outcome) {
        change->energy = energy_at(&s, q, u) - (left[0] + left[1]);
        outcome = break_joints(it, reaction);
    }
end:
    give_back(arena, mark);
    return outcome;
}

int is_of_joint(const struct ccgen_simulation *it, int i)
{
    return is_change(it->system.model, i);
}

static enum outcome set_gate(struct ccgen_simulation *it, int gate, double held, int indicator, int limits)
{
    it->run.values[gate] = held;
    derive_parameters(it);
    struct ccgen_change *change = try_change(it, indicator, gate);
    if (!change)
        return OUTCOME_NO_MEMORY;
    return held == 0.0 ? OUTCOME_DONE : take_hold(it, gate, limits, change);
}

enum outcome change_joint(struct ccgen_simulation *it, int i, int *sets)
{
    const struct ccgen_model *m = it->system.model;
    if (it->run.values[m->gate_of[i]] != m->held_before[i]) /* another has done it at the same instant */
        return OUTCOME_DONE;
    *sets = 1;
    return set_gate(it, m->gate_of[i], !m->held_before[i], i, i);
}

enum outcome change_gate(struct ccgen_simulation *it, int gate, double held)
{
    const struct ccgen_model *m = it->system.model;
    int i = 0;
    if (held != 0.0 && held != 1.0)
        return OUTCOME_CANNOT_SET;
    while (i < m->indicators && !(is_change(m, i) && m->gate_of[i] == gate && !m->held_before[i]))
        i++;
    return set_gate(it, gate, held, -1, i < m->indicators ? i : -1);
}
