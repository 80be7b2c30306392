/* The thresholds as a table; see tolerances.h. */
#include "base/tolerances.h"

#ifdef CCGEN_VARIABLE_TOLERANCES
#define DEFINED(name, value, of, decides, because) double name = value;
ALL_TOLERANCES(DEFINED)
#endif

#define ENTRY(name, value, of, decides, because) {#name, value, of, decides, because},
const struct tolerance_entry tolerance_entries[] = {ALL_TOLERANCES(ENTRY){NULL, 0.0, OF_RELATIVE, NULL, NULL}};

#define NUMBER(name, value, of, decides, because) NUMBER_##name,
enum { ALL_TOLERANCES(NUMBER) };

#define ORDER(less, more) {NUMBER_##less, NUMBER_##more},
const struct tolerance_order tolerance_orders[] = {ALL_ORDERS(ORDER){-1, -1}};
