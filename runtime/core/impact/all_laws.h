/* The list of the laws of impact: a new one is a file in this folder and a line here. What restitution is a ratio of: speeds (Newton),
 * impulses (Poisson), or, squared, work (Stronge). */
#ifndef CCGEN_ALL_LAWS_H
#define CCGEN_ALL_LAWS_H

#define ALL_LAWS(LAW) \
    LAW(newton)       \
    LAW(poisson)      \
    LAW(stronge)

#endif
