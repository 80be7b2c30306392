/* A model as one of which further rows of the closure are off: all its functions are those of the model, with zeros for these rows. */
#include <string.h>

#include "model.h"

enum { MOST = 64 }; /* rows, of which `place` says where those of the model are */

static const struct ccgen_model *base;
static struct ccgen_model padded;
static int place[MOST], partner[MOST], held[MOST];

/* out[rows] from those of the model, `width` numbers each, and back */
static void spread(int width, const double *rows, double *out)
{
    memset(out, 0, (size_t)padded.rows * width * sizeof *out);
    for (int i = 0; i < base->rows; i++)
        memcpy(out + (size_t)place[i] * width, rows + (size_t)i * width, width * sizeof *out);
}

static const double *gather(const double *rows, double *out)
{
    for (int i = 0; rows && i < base->rows; i++)
        out[i] = rows[place[i]];
    return rows ? out : NULL;
}

static int acceleration(const double *k, const double *q, const double *u, double t, const double *inputs,
                        double *u_dot, double *lambda)
{
    double own[MOST];
    const int lost = base->acceleration(k, q, u, t, inputs, u_dot, lambda ? own : NULL);
    if (lambda)
        spread(1, own, lambda);
    return lost;
}

static int impulse(const double *k, const double *q, const double *f, const double *y, double *du, double *Lambda)
{
    double own[MOST], rates[MOST];
    const int lost = base->impulse(k, q, f, gather(y, rates), du, Lambda ? own : NULL);
    if (Lambda)
        spread(1, own, Lambda);
    return lost;
}

static void reactions(const double *k, const double *q, const double *u, double t, const double *inputs,
                      const double *u_dot, const double *lambda, double *reaction)
{
    double own[MOST];
    base->reactions(k, q, u, t, inputs, u_dot, gather(lambda, own), reaction);
}

static void impulse_reactions(const double *k, const double *q, const double *du, const double *Lambda,
                              double *reaction)
{
    double own[MOST];
    base->impulse_reactions(k, q, du, gather(Lambda, own), reaction);
}

static void power(const double *k, const double *q, const double *u, double t, const double *inputs,
                  const double *u_dot, const double *lambda, double *found)
{
    double own[MOST];
    base->power(k, q, u, t, inputs, u_dot, gather(lambda, own), found);
}

static void closure(const double *k, const double *q, double *out)
{
    double own[MOST];
    if (base->rows)
        base->closure(k, q, own);
    spread(1, own, out);
}

static void closure_rate(const double *k, const double *q, const double *u, double *out)
{
    double own[MOST];
    if (base->rows)
        base->closure_rate(k, q, u, own);
    spread(1, own, out);
}

static void closure_bias(const double *k, const double *q, const double *u, double *out)
{
    double own[MOST];
    if (base->rows)
        base->closure_bias(k, q, u, own);
    spread(1, own, out);
}

static void closure_jacobian(const double *k, const double *q, double *out)
{
    double own[MOST * MOST];
    if (base->rows)
        base->closure_jacobian(k, q, own);
    spread(base->nu, own, out);
}

/* The model `of`, which has no derivatives, with `count` rows more, before its row number `before`: pins, if `pins` are asked for, which a last parameter gates, or that are always on
 * where `marked` is 0. NULL where it is too large. */
const struct ccgen_model *with_rows_off(const struct ccgen_model *of, int before, int count, int pins, int marked)
{
    if (of->rows + count > MOST || of->nu > MOST)
        return NULL;
    base = of;
    padded = *of;
    padded.rows += count;
    padded.parameters++;
    for (int i = 0; i < padded.rows; i++) {
        const int more = i >= before && i < before + count;
        held[i] = more && marked ? of->parameters : -1;
        partner[i] = more ? (pins ? before + ((i - before) ^ 1) : i) : -1;
    }
    for (int i = 0; i < of->rows; i++)
        place[i] = i < before ? i : i + count;
    for (int i = 0; i < of->rows; i++)
        partner[place[i]] = place[of->partner[i]];
    padded.partner = partner;
    padded.row_held = held;
    padded.acceleration = acceleration; /* that over lanes is asked for no multipliers */
    padded.impulse = impulse;
    padded.reactions = reactions;
    padded.impulse_reactions = of->impulse_reactions ? impulse_reactions : NULL;
    padded.power = of->power ? power : NULL;
    padded.closure = closure;
    padded.closure_rate = closure_rate;
    padded.closure_bias = closure_bias;
    padded.closure_jacobian = closure_jacobian;
    return &padded;
}
