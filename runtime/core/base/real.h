/* The numbers that the core computes with.
 *
 * The files of the core are written over `double`. Compiled with CCGEN_PRECISION 1 or 2 they are the same program in float or
 * in long double: there `double`, its limits, and the functions of the C library are those of that type. Everything of the
 * C library that the core uses is included here, before that.
 */
#ifndef CCGEN_REAL_H
#define CCGEN_REAL_H

#include <complex.h>
#include <float.h>
#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#ifndef CCGEN_PRECISION
#define CCGEN_PRECISION 0
#endif

/* about the square root of the numbers' rounding */
#if CCGEN_PRECISION == 1
#define CCGEN_ROOT_EPSILON 3.5e-4f
#elif CCGEN_PRECISION == 2 && LDBL_MANT_DIG > DBL_MANT_DIG
#define CCGEN_ROOT_EPSILON 3.5e-10
#else
#define CCGEN_ROOT_EPSILON 1.5e-8
#endif

/* A limit that tells what counts from rounding: in floats another one, further from their coarser rounding, in long doubles
 * the one of doubles. About the same power of the rounding in floats and doubles, so the same share of the digits. */
#if CCGEN_PRECISION == 1
#define CCGEN_LIMIT(of_doubles, of_floats) of_floats##f
#else
#define CCGEN_LIMIT(of_doubles, of_floats) of_doubles
#endif

#if CCGEN_PRECISION == 1
#define CCGEN_OF_TYPE(name) name##f
#undef DBL_EPSILON
#define DBL_EPSILON FLT_EPSILON
#undef DBL_MAX
#define DBL_MAX FLT_MAX
#undef DBL_MIN
#define DBL_MIN FLT_MIN
#define double float
#elif CCGEN_PRECISION == 2
#define CCGEN_OF_TYPE(name) name##l
#undef DBL_EPSILON
#define DBL_EPSILON LDBL_EPSILON
#undef DBL_MAX
#define DBL_MAX LDBL_MAX
#undef DBL_MIN
#define DBL_MIN LDBL_MIN
#define double long double
#endif

#if CCGEN_PRECISION
#define acos CCGEN_OF_TYPE(acos)
#define cabs CCGEN_OF_TYPE(cabs)
#define cimag CCGEN_OF_TYPE(cimag)
#define copysign CCGEN_OF_TYPE(copysign)
#define cos CCGEN_OF_TYPE(cos)
#define creal CCGEN_OF_TYPE(creal)
#define fabs CCGEN_OF_TYPE(fabs)
#define frexp CCGEN_OF_TYPE(frexp)
#define ldexp CCGEN_OF_TYPE(ldexp)
#define pow CCGEN_OF_TYPE(pow)
#define sin CCGEN_OF_TYPE(sin)
#define sqrt CCGEN_OF_TYPE(sqrt)
#endif

/* fmax and fmin of the C library are calls, since they order zeros by their signs too. Nothing here asks for that; a number
 * goes before what is none, as there. */
static inline double ccgen_larger(double a, double b)
{
    return a > b || b != b ? a : b;
}

static inline double ccgen_smaller(double a, double b)
{
    return a < b || b != b ? a : b;
}

#undef fmax
#undef fmin
#define fmax ccgen_larger
#define fmin ccgen_smaller

#endif
