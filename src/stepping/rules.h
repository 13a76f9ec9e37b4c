/* The constants of the time steps and of Newton's method: each with its reason, what it was
   measured on and the test that fails without it, in rules.def; docs/dev/heuristics.md is made of
   these. */
#ifndef TENDRIL_STEPPING_RULES_H
#define TENDRIL_STEPPING_RULES_H

#include <petscsys.h>

typedef struct {
#define RULE(type, name, value, text, measured, test) type name;
#include "stepping/rules.def"
#undef RULE
} StepRules;

static const StepRules step_rule = {
#define RULE(type, name, value, text, measured, test) value,
#include "stepping/rules.def"
#undef RULE
};

#endif
