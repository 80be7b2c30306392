/* What a run has found, given back. */
#include "record/run.h"

#include <stdlib.h>
#include <string.h>

void free_run(struct run *run)
{
    free(run->modes.t);
    free(run->modes.first);
    free(run->modes.contact);
    free(run->modes.mode);
    memset(&run->modes, 0, sizeof run->modes);
    free(run->stepping.t0);
    free(run->stepping.t1);
    free(run->stepping.step);
    free(run->stepping.miss);
    free(run->stepping.first);
    free(run->stepping.last);
    free(run->stepping.jump);
    memset(&run->stepping, 0, sizeof run->stepping);
    free(run->record.t);
    free(run->record.y);
    free(run->record.events);
    free(run->impacts.t);
    free(run->impacts.u_minus);
    free(run->impacts.u_plus);
    free(run->impacts.energy_loss);
    free(run->impacts.share);
    free(run->impacts.first);
    free(run->impacts.after);
    free(run->impacts.contact);
    free(run->impacts.impulse);
    free(run->impacts.friction);
    memset(&run->record, 0, sizeof run->record);
    memset(&run->impacts, 0, sizeof run->impacts);
}
