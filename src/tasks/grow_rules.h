/* The constants of -task grow: start, choice of model, end, errors: each with its reason, what it
   was measured on and the test that fails without it, in grow_rules.def; docs/dev/heuristics.md is
   made of these. */
#ifndef TENDRIL_GROW_RULES_H
#define TENDRIL_GROW_RULES_H

#include <petscsys.h>

typedef struct {
#define RULE(type, name, value, text, measured, test) type name;
#include "tasks/grow_rules.def"
#undef RULE
} GrowRules;

static const GrowRules grow_rule = {
#define RULE(type, name, value, text, measured, test) value,
#include "tasks/grow_rules.def"
#undef RULE
};

#endif
