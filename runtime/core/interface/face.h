/* The core as the compiled face of the runtime sees it: its types and functions, and `double` a double again. */
#ifndef CCGEN_FACE_H
#define CCGEN_FACE_H

#include "algebra/inverse.h"
#include "base/tolerances.h"
#include "base/within.h"
#include "constraints/impulse.h"
#include "constraints/nullspace.h"
#include "impact/impact.h"
#include "impact/law.h"
#include "interface/between.h"
#include "interface/calls.h"
#include "interface/collocation.h"
#include "interface/crossings.h"
#include "interface/ensemble.h"
#include "interface/forces.h"
#include "interface/held_tangents.h"
#include "interface/limits.h"
#include "interface/simulation.h"
#include "methods/method.h"
#include "model/contacts.h"
#include "model/inputs.h"
#include "model/scales.h"
#include "model/second_links.h"
#include "motion/acceleration.h"
#include "motion/carried.h"
#include "motion/lanes.h"
#include "motion/projection.h"
#include "motion/rounding.h"
#include "motion/tangent.h"

typedef double ccgen_real;

#if CCGEN_PRECISION == 1
#define CCGEN_CAPSULE "ccgen.model.float"
#elif CCGEN_PRECISION == 2
#define CCGEN_CAPSULE "ccgen.model.wide"
#else
#define CCGEN_CAPSULE "ccgen.model"
#endif

#undef double
#undef acos
#undef cabs
#undef cimag
#undef copysign
#undef cos
#undef creal
#undef fabs
#undef fmax
#undef fmin
#undef frexp
#undef ldexp
#undef pow
#undef sin
#undef sqrt

#endif
