/* Inputs of the model: what supplies them is asked at every state; a table is interpolated. */
#include "model/inputs.h"

enum outcome supply_inputs(struct system *s, double t, const double *q, const double *u)
{
    if (!s->input_source || !s->input_source(s->context, t, q, u, s->inputs))
        return OUTCOME_DONE;
    if (s->interruption)
        s->interruption->ended = 1;
    return OUTCOME_INTERRUPTED;
}

int input_from_table(void *context, double t, const double *q, const double *u, double *inputs)
{
    struct input_table *table = context;
    const size_t last = table->count - 1;
    size_t low = table->row;
    (void)q;
    (void)u;
    if (low >= last || t < table->t[low] || t >= table->t[low + 1]) { /* another interval: bisection */
        size_t high = last;
        low = 0;
        while (high > low + 1) {
            const size_t middle = low + (high - low) / 2;
            if (t < table->t[middle])
                high = middle;
            else
                low = middle;
        }
        table->row = low;
    }
    const double *a = table->values + low * table->width, *b = low < last ? a + table->width : a;
    const double length = low < last ? table->t[low + 1] - table->t[low] : 1.0, part = (t - table->t[low]) / length;
    for (int i = 0; i < table->width; i++)
        inputs[i] = part <= 0.0 ? a[i] : part >= 1.0 ? b[i] : a[i] + part * (b[i] - a[i]);
    return 0;
}
