/* The thresholds as a table; see tolerances.h. */
#include "base/tolerances.h"

#ifdef CCGEN_VARIABLE_TOLERANCES
#define DEFINED(name, value, of, decides, because) double name = value;
#define NOTHING(layer)
ALL_TOLERANCES(DEFINED, NOTHING)
#endif

#define ENTRY(name, value, of, decides, because) {#name, value, of, decides, because},
#define HEADING(layer) {#layer, 0.0, OF_RELATIVE, NULL, NULL},
const struct tolerance_entry tolerance_entries[] = {ALL_TOLERANCES(ENTRY, HEADING){NULL, 0.0, OF_RELATIVE, NULL, NULL}};

#define NUMBER(name, value, of, decides, because) NUMBER_##name,
#define NUMBER_OF_LAYER(layer) NUMBER_OF_##layer,
enum { ALL_TOLERANCES(NUMBER, NUMBER_OF_LAYER) };

#define ORDER(less, more) {NUMBER_##less, NUMBER_##more},
const struct tolerance_order tolerance_orders[] = {ALL_ORDERS(ORDER){-1, -1}};
