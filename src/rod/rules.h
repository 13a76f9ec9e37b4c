/* The constants of the models of the rod, and of what they touch: each with its reason, what it was
   measured on and the test that fails without it, in rules.def; docs/dev/heuristics.md is made of
   these. */
#ifndef TENDRIL_ROD_RULES_H
#define TENDRIL_ROD_RULES_H

#include <petscsys.h>

typedef struct {
#define RULE(type, name, value, text, measured, test) type name;
#include "rod/rules.def"
#undef RULE
} RodRules;

static const RodRules rod_rule = {
#define RULE(type, name, value, text, measured, test) value,
#include "rod/rules.def"
#undef RULE
};

#endif
