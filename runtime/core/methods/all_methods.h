/* The list of integration methods: a new one is a file in this folder and a line here, in the order in which they are told. */
#ifndef CCGEN_ALL_METHODS_H
#define CCGEN_ALL_METHODS_H

#define ALL_METHODS(METHOD) \
    METHOD(dop853)          \
    METHOD(gauss)           \
    METHOD(dopri5)          \
    METHOD(radau)           \
    METHOD(moreau)

#endif
