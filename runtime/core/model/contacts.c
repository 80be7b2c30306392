/* Gaps of contacts as lengths; see contacts.h. */
#include "model/contacts.h"

#include "algebra/power_of_two.h"

void set_levers(struct system *s, const unsigned char *angular, double *lever, double *extent)
{
    int any = 0;
    for (int c = 0; c < s->model->contacts; c++) {
        const int turns = angular && angular[c];
        lever[c] = turns ? power_of_two(s->length) : 1.0;
        extent[c] = turns ? lever[c] : s->length;
        any |= turns;
    }
    s->lever = any ? lever : NULL;
    s->extent = extent;
}

static void as_lengths(const struct system *s, double *values)
{
    for (int c = 0; s->lever && c < s->model->contacts; c++)
        values[c] *= s->lever[c];
}

void contact_gaps(const struct system *s, const double *q, double *gaps)
{
    s->model->gaps(s->k, q, gaps);
    as_lengths(s, gaps);
}

void contact_rates(const struct system *s, const double *q, const double *u, double *rates)
{
    s->model->gap_rates(s->k, q, u, rates);
    as_lengths(s, rates);
}

void contact_bias(const struct system *s, const double *q, const double *u, double *bias)
{
    s->model->gap_bias(s->k, q, u, bias);
    as_lengths(s, bias);
}
