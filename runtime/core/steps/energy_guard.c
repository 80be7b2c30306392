/* Steps that do not keep the energy are refused.
 *
 * Error estimates compare states, and projection puts states back onto the closure. Near a singular configuration both are blind
 * to one direction (docs/theory, section 8): a step may come out with wrong velocities along it, and nothing of that shows but
 * in the energy. Loops that fall on grounds come as near to such configurations as it pleases them, so there each step's
 * energy is an error like others. What a refused step would have covered may not miss more in pieces than it may in one, or short
 * steps would let through bit by bit what they are there to stop.
 */
#include "steps/energy_guard.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "base/tolerances.h"
#include "constraints/nullspace.h"
#include "motion/derivative.h"

/* Part of what a place hides that rounding is likely to be: two roundings of sixteen. More may be an error of the step. */
static const double LIKELY = 0.125;

/* Share that is not known of the work of friction, and of whatever else takes energy: at the distance sigma from dependence,
 * where contacts are pressed as hard as 1 / sigma, velocities are known to rounding / sigma^2 only. It is lost whatever it is. */
static double unknown_work(const struct phase *f)
{
    const double sigma = fmin(rank_margin(f->s, f->y), rank_margin(f->s, f->y1));
    return fmin(0.5, TANGENT * DBL_EPSILON / (sigma * sigma));
}

/* Energies at both ends of the step: what it gains (J) beyond the work that is done, and what has been in motion */
static double gained(struct phase *f, double *done, double *moves)
{
    const struct system *s = f->s;
    const int work = 2 * s->n;
    if (!f->at.energy_known)
        s->model->energy(s->k, f->y, f->y + s->n, f->at.energy);
    f->at.energy_known = 1;
    s->model->energy(s->k, f->y1, f->y1 + s->n, f->at.energy_end);
    f->at.energy_h = f->h;
    const double *e0 = f->at.energy, *e1 = f->at.energy_end;
    *done = s->size > work ? f->y1[work] - f->y[work] : 0.0;
    *moves = fmax(f->at.energy_in_motion, e0[0] + fabs(e1[1] - e0[1]) + fabs(*done));
    return (e1[0] - e0[0]) + (e1[1] - e0[1]) - *done;
}

/* Whether the step is one that may have wrong velocities at its end: without contacts a motion follows its branch where rows are near dependence. */
static int guarded(const struct phase *f)
{
    return f->s->rows_on && f->s->model->contacts;
}

/* J: what is not known of the work of the load of held contacts, the forces that they would have as the step begins if nothing moved. Places are known to rounding: what lies
 * still where heights are counted from has no other energy to be measured by. And smooth contacts may push along the motion, which they do not, but for rounding: what
 * lies still but for a slow slide, which nothing ends, has little energy in motion, against which that counts. What motion adds to forces is as large as it pleases
 * them beside a singular configuration, where this is to tell wrong velocities. */
static double unknown_work_of_loads(struct phase *f)
{
    struct system *s = f->s;
    const struct mark mark = s->arena->top;
    double *still = TAKE(s->arena, double, s->size), *dy = TAKE(s->arena, double, s->size);
    const size_t rows = 2 * (size_t)s->model->contacts;
    double *forces = TAKE(s->arena, double, rows), force = 0.0, smooth = 0.0;
    int known = active_count(s) && !s->arena->ran_out;
    if (known) {
        memcpy(still, f->y, s->size * sizeof *still);
        memset(still + s->n, 0, s->n * sizeof *still);
        memcpy(forces, s->active->force, rows * sizeof *forces); /* the next evaluation begins with them */
        known = !system_derivative(s, f->t, still, dy);
        for (int i = 0; i < active_count(s) && known; i++) {
            force += fabs(s->active->force[i]);
            smooth += s->active->mode[i] == FRICTIONLESS ? fabs(s->active->force[i]) : 0.0;
        }
        memcpy(s->active->force, forces, rows * sizeof *forces);
    }
    give_back(s->arena, mark);
    const double slides = smooth > 0.0 ? smooth * fastest(s, f->y + s->n) * f->h : 0.0;
    return ENERGY_ROUNDING * s->length * (force + slides);
}

double energy_residual(struct phase *f, double *unknown)
{
    const struct system *s = f->s;
    double done, moves;
    *unknown = 0.0;
    if (!guarded(f) || f->run->fixed_step > 0.0)
        return 0.0;
    const double gain = gained(f, &done, &moves), *e0 = f->at.energy;
    const double part = f->t < f->at.stretch_end ? fmin(1.0, f->h / f->at.stretch) : 1.0;
    const double known = KEPT * part * f->run->tolerance.rtol * moves + ENERGY_ROUNDING * (e0[0] + fabs(e0[1]) + moves);
    const double hidden = 2.0 * missed_velocity(f) * moves;
    const double loads = fabs(gain) > OFTEN * (known + hidden) ? unknown_work_of_loads(f) : 0.0;
    const double may = known + hidden + loads;
    double missed = fabs(gain) / may;
    *unknown = hidden > 0.0 && fabs(gain) > known + LIKELY * hidden + loads ? fabs(gain) : 0.0;
    if (missed > OFTEN && done < 0.0 && active_count(s) && s->friction)
        missed = fmax(0.0, missed + unknown_work(f) * done / may);
    if (missed > 1.0 && !(f->t < f->at.stretch_end)) {
        f->at.stretch = f->h;
        f->at.stretch_end = f->t + f->h;
    }
    return missed;
}

int breaks_energy(struct phase *f)
{
    double done, moves;
    if (!guarded(f))
        return 0;
    return fabs(gained(f, &done, &moves)) > GROSS * moves;
}

void commit_energy(struct phase *f)
{
    f->at.energy_known = f->at.energy_known && f->at.energy_h == f->h;
    f->at.energy_h = 0.0; /* the next step's is not known yet */
    if (!f->at.energy_known)
        return;
    f->at.energy_in_motion =
        fmax(f->at.energy_in_motion, f->at.energy[0] + fabs(f->at.energy_end[1] - f->at.energy[1]));
    f->at.energy[0] = f->at.energy_end[0];
    f->at.energy[1] = f->at.energy_end[1];
}
