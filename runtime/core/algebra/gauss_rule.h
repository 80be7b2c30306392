/* Gauss's rule with eight points on [0, 1], from 60 digits: exact for polynomials of degree 15. The tests check it against the conditions that define it. */
#ifndef CCGEN_GAUSS_RULE_H
#define CCGEN_GAUSS_RULE_H

#pragma GCC system_header /* numbers have the digits of long doubles, and are rounded to the core's type without a warning */

enum { STAGES = 8 };

/* nodes: zeros of the Legendre polynomial of degree 8, on [0, 1] */
static const double NODE[STAGES] = {0.01985507175123188415821957L, 0.1016667612931866302042230L,
                                    0.2372337950418355070911305L,  0.4082826787521750975302619L,
                                    0.5917173212478249024697381L,  0.7627662049581644929088695L,
                                    0.8983332387068133697957770L,  0.9801449282487681158417804L};

/* weights of the integral */
static const double WEIGHT[STAGES] = {0.05061426814518812957626568L, 0.1111905172266872352721780L,
                                      0.1568533229389436436689811L,  0.1813418916891809914825752L,
                                      0.1813418916891809914825752L,  0.1568533229389436436689811L,
                                      0.1111905172266872352721780L,  0.05061426814518812957626568L};

#endif
