/* A run; see simulate.h. */
#include "interface/simulate.h"

#include <math.h>
#include <string.h>

#include "hybrid/automaton.h"
#include "motion/projection.h"
#include "steps/phase.h"
#include "steps/step_control.h"

void simulate(struct system *s, struct run *run, double *y)
{
    struct phase f = {.s = s, .run = run, .t = run->start, .place = NAN};
    run->contact = -1;
    run->second = run->start;
    run->spent_before = run->events = 0;
    run->outcome = OUTCOME_NO_MEMORY;
    if (!make_phase(&f)) {
        memcpy(f.y, y, (size_t)s->size * sizeof *y);
        run->outcome = project_position(s, f.y);
        if (!run->outcome)
            run->outcome = project_velocity(s, f.y, f.y + s->n);
        if (!run->outcome && record_state(&f))
            run->outcome = OUTCOME_NO_MEMORY;
        if (!run->outcome) {
            start_asking(&run->interruption, run->start);
            s->interruption = &run->interruption;
            run->outcome = run_automaton(&f);
            s->interruption = NULL;
        }
        if (run->record.count && f.t > run->record.t[run->record.count - 1] && record_state(&f))
            run->outcome = OUTCOME_NO_MEMORY;
    }
    run->t = f.t;
    free_phase(&f);
}

enum outcome advance(struct system *s, const struct method *method, struct tolerance tolerance, enum drift drift,
                     double t, double h, int count, const int *set, const signed char *mode, double *y)
{
    struct run run = {.method = method, .tolerance = tolerance, .drift = drift};
    struct phase f = {.s = s, .run = &run, .t = t, .place = NAN};
    enum outcome outcome = OUTCOME_NO_MEMORY;
    if (!make_phase(&f)) {
        if (count)
            activate(&f.active, count, set, mode);
        memcpy(f.y, y, (size_t)s->size * sizeof *y);
        outcome = evaluate_derivative(&f);
        if (!outcome)
            outcome = s->model->contacts || tolerance.rtol == 0.0 ? projected_step(&f, h) : integrate_to(&f, t + h);
        if (!outcome)
            memcpy(y, f.y1, (size_t)s->size * sizeof *y);
    }
    free_phase(&f);
    return outcome;
}
