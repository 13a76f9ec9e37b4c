#!/usr/bin/env python3
"""Does a test notice? Each constant and each heuristic of the stepper is changed or switched off, one at a
time, in a copy of the source; the tests that could see it run until one fails.

    mutations.py SCRATCH [--only REGEX] [--tests REGEX] [--longest 20] [--through "nice -n 9"] [--again]

Prints what notices each; what has survived all tests is listed at the end (exit 1). SCRATCH keeps the copy,
its build, found.csv, with which a run that was broken off goes on, and times.csv, how long each test takes.
--only: of these mutations; --tests: of these tests; --longest: of those that take so many seconds at most;
--through: a command by which builds and tests are run; --again: also those that found.csv has."""

import argparse
import collections
import csv
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

# (name, file in src, what stands there, what stands in its place)
F, C, N, L, E = ("stepping/" + f for f in ("formula.c", "controller.c", "newton.c", "leg.c", "estimate.c"))
S, R, G = "stepping/rules.def", "rod/rules.def", "tasks/grow_rules.def"  # the registers of constants


def rule(register, name, value, other):
    """Another value of a constant."""
    return register, f" {name}, {value},", f" {name}, {other},"


MUTATIONS = [
    # -- steps: what is a jump
    ("jump_persists, never", *rule(S, "jump_persists", "0.7", "1e9")),
    ("jump_persists, soon", *rule(S, "jump_persists", "0.7", "0.4")),
    ("jump_step, none", *rule(S, "jump_step", "1e-13", "0")),
    ("longest_jump, no doubling", *rule(S, "longest_jump", "1e-6", "1e-13")),
    ("longest_jump, longer", *rule(S, "longest_jump", "1e-6", "1e-3")),
    ("slip_persists, none", *rule(S, "slip_persists", "0.25", "0.7")),
    ("slip_step, long", *rule(S, "slip_step", "1e-8", "1e-3")),
    ("rejected, of any size", C, "if (*factor > 1. / 3) self->rejected = PETSC_MAX_REAL;", ""),
    ("first error, none", C, "  if (!self->guess) PetscFunctionReturn(0);\n", "  PetscFunctionReturn(0);\n"),
    # -- steps: length, order, factor
    ("smallest, smaller", *rule(S, "smallest_step", "1e-16", "1e-25")),
    ("smallest, greater", *rule(S, "smallest_step", "1e-16", "1e-9")),
    ("safety, high", *rule(S, "error_aim", "0.22", "0.8")),
    ("safety, low", *rule(S, "error_aim", "0.22", "0.05")),
    ("shrink_most, little", *rule(S, "shrink_most", "0.2", "0.7")),
    ("shrink_most, much", *rule(S, "shrink_most", "0.2", "0.001")),
    ("grow_most, more", *rule(S, "grow_most", "2", "100")),
    ("grow_most, little", *rule(S, "grow_most", "2", "1.2")),
    ("after a rejection, not shorter", C, "*accept ? step_rule.grow_most : 0.9", "*accept ? step_rule.grow_most : 1"),
    ("cut, little", *rule(S, "failed_cut", "0.3", "0.9")),
    ("cut, much", *rule(S, "failed_cut", "0.3", "0.01")),
    ("better, never", *rule(S, "factor_better", "0.5", "0")),
    ("better, at once", *rule(S, "factor_better", "0.5", "1")),
    ("most_folds, any", *rule(S, "factor_change", "4", "1e9")),
    ("most_folds, few", *rule(S, "factor_change", "4", "0.2")),
    ("vanished, less", *rule(S, "field_vanished", "1e-280", "0")),
    ("vanished, more", *rule(S, "field_vanished", "1e-280", "1e-100")),
    ("degree above the order", F, "PetscMin(self->degree, q) + 1", "self->degree + 1"),
    ("order, up at any time", C, "(self->since > k || f->n < self->most + 2)", "1"),
    ("order, up late", C, "(self->since > k || f->n < self->most + 2)", "self->since > k"),
    ("order, never down", C, "if (StepFactor(lower, k - 1) > *factor) {", "if (0) {"),
    ("since, after a rejection", C, "  self->since = 0;\n  if (attempt >= 3)", "  if (attempt >= 3)"),
    ("history kept", C, "if (attempt >= 3) {", "if (0) {"),
    ("history dropped at once", C, "if (attempt >= 3) {", "if (1) {"),
    ("left / 2", C, "else if (!self->fixed && ts->time_step > left / 2)", "else if (0)"),
    ("NaN let through", C, "if (!(size < step_rule.error_overflows)) solved = DIVERGED_NAN;", ""),
    ("check, none", C, "if (!self->check || *solved < 0) PetscFunctionReturn(0);", "PetscFunctionReturn(0);"),
    # -- modes that grow
    ("cross, never asked", C, "if (!self->cross) PetscFunctionReturn(0);", "PetscFunctionReturn(0);"),
    ("cross, not where predicted nor half-way", C, "if (sight != VBDF_SEEN && !*crosses) {", "if (0) {"),
    ("cross, not where predicted", C, "PetscCall(CrossesAt(ts, self, f, self->work, sight, crosses));\n    PetscCall(VecAXPBY",
     "PetscCall(VecAXPBY"),
    ("cross, not half-way", C, "if (!*crosses) PetscCall(CrossesAt(ts, self, f, self->work, sight, crosses));", ""),
    ("cross, the next step's matrix", C,
     "    if (!*crosses)\n      PetscCall(CrossesAt(ts, self, f, f->point[0], sight, crosses)); /* for the next step */\n", ""),
    ("cross, a layer is a jump", C, "sight = ts->time_step < self->layer ? VBDF_BLIND : VBDF_JUMP;", "sight = VBDF_JUMP;"),
    ("cross, order and memory stay", C,
     "  self->order = order;\n  self->jumped = PETSC_FALSE;\n  self->rejected = PETSC_MAX_REAL;\n  PetscFunctionReturn(0);\n}\n\n/* Solves the",
     "  self->jumped = PETSC_FALSE;\n  PetscFunctionReturn(0);\n}\n\n/* Solves the"),
    ("cross, rubbing walls as others", "rod/ask.c", "(ContactWallsRub(contact) || contact", "(contact"),
    ("cross, rubbing strands as others", "rod/ask.c", "contact->friction > 0 ||", ""),
    ("cross, coupled as others", "rod/ask.c", "rod->coupled ||", ""),
    ("cross, across as along", "rod/ask.c", "load->turns ||", ""),
    ("cross, resting as moving", "rod/ask.c", "|| scene->growth->rests);", ");"),
    ("cross, parity ignored", "stepping/leg_modes.c", "index <= 0 && index % 2 == 0", "index <= 0"),
    ("cross, unknown is free", "stepping/leg_modes.c", "if (!known && sight == VBDF_JUMP)", "if (0)"),
    ("cross, on the straight rod too", "stepping/leg_modes.c", "*bent = PETSC_FALSE;", "*bent = PETSC_TRUE;"),
    # -- leg
    ("share_of_step, all", *rule(S, "step_share", "0.3", "3")),
    ("share_of_step, little", *rule(S, "step_share", "0.3", "0.01")),
    ("highest order 5", *rule(S, "highest_order", "6", "5")),
    ("kicked, never", *rule(S, "wall_onset", "1e-4", "0")),
    ("kicked, soon", *rule(S, "wall_onset", "1e-4", "0.1")),
    ("kick, never over", L, "if (t >= of->kick_ends) of->kick[f] = 0;", ""),
    ("longer than it is", L, "Reach(rod->model, of->tried) <= step_rule.reach_slack * length);", "1);"),
    ("guard, none", L, "PetscCall(GuardPasses(ts, t0, t1, U0, U1, impossible));", ""),
    ("first guess at rest", L, "PetscCall(RodGrowNodes(rod, t0, t1, nodes));", ""),
    ("theta not extrapolated", L, "if (theta && !given) PetscCall(PetscOptionsSetValue(NULL, option, \"true\"));", ""),
    ("linear, no second look", L, "if (vbdf || !leg->rod->model->linear) PetscFunctionReturn(0);", "PetscFunctionReturn(0);"),
    ("a first step 100 times as long", L, "TSSetTimeStep(leg->ts, first)", "TSSetTimeStep(leg->ts, 100 * first)"),
    ("rejections, 10", L, "TSSetMaxStepRejections(leg->ts, 50)", "TSSetMaxStepRejections(leg->ts, 10)"),
    ("failures of fixed steps, none", L, "TSSetMaxSNESFailures(leg->ts, 10)", "TSSetMaxSNESFailures(leg->ts, 0)"),
    # -- Newton's method
    ("share_of_tolerance, all", *rule(S, "newton_share", "0.02", "2")),
    ("share_of_tolerance, little", *rule(S, "newton_share", "0.02", "2e-5")),
    ("round_off, none", *rule(S, "update_round_off", "1e-13", "0")),
    ("share_of_rate, any", *rule(S, "rate_margin", "0.5", "100")),
    ("rate, not used", N, "|| left * rate <= step_rule.rate_margin * floor)", ")"),
    ("rate, of residuals alone", N, "if (it > 1 && !RodTouches(self->rod)) rate = PetscMin(rate, left / self->update);", ""),
    ("loose, not at all", *rule(S, "force_settles", "1e-4", "1e4")),
    ("loose, tight", *rule(S, "force_settles", "1e-4", "1e-12")),
    ("patience, none", *rule(S, "force_iterations", "8", "0")),
    ("patience, any", *rule(S, "force_iterations", "8", "1000")),
    ("forces in a row, never", N, "RodTouches(self->rod) && followed > floor ? 0", "0 && followed > floor ? 0"),
    ("hopeless, never", N, "RodTouches(self->rod) &&\n                     (cut", "0 && (cut"),
    ("hopeless, free rods", N, "RodTouches(self->rod) &&\n                     (cut", "1 && (cut"),
    ("creeping, to the last", *rule(S, "stalls_iterations", "15", "1000")),
    ("diverging, once", *rule(S, "diverges_times", "4", "1")),
    ("diverging, early", *rule(S, "diverges_earliest", "8", "1")),
    ("diverging, to the last", *rule(S, "diverges_times", "4", "1000")),
    ("the limit, by the linear model", "tasks/grow_begin.c", "(asked || LoadIsNextToExact(&self->scene->load))", "asked"),
    ("the limit, fitted", *rule(G, "beta_error", "40", "10")),
    ("groups lumped", N, "    residual[rod->model->group[f]] =\n        PetscMax(residual[rod->model->group[f]], size[f] / RodFieldUnit(rod, f));",
     "    for (int g = 0; g < GROUPS; g++) residual[g] = PetscMax(residual[g], size[f] / RodFieldUnit(rod, f));"),
    ("creep, any", *rule(S, "stick_slips", "5", "1e9")),
    ("creep, none", *rule(S, "stick_slips", "5", "0")),
    ("holds, one", *rule(S, "stick_updates", "2", "1")),
    ("holds, many", *rule(S, "stick_updates", "2", "20")),
    ("held to the full by walls", N, "if (!RodTouches(self->rod)) return 0;", "return 0;"),
    ("iterations, 12", N, "PETSC_DEFAULT, 40, 1000000", "PETSC_DEFAULT, 12, 1000000"),
    ("never held", N, "&& self->rod->model->hold)\n", "&& 0)\n"),
    # -- snaps
    ("least_share, none", "world/load.c", "least_share = 1e-6;", "least_share = 0;"),
    ("least_share, large", "world/load.c", "least_share = 1e-6;", "least_share = 1e-3;"),
    ("least_share, at any speed", "world/load.c", "const PetscReal fast = 10;", "const PetscReal fast = 0;"),
    ("snaps_at, never", *rule(S, "snaps_at", "1e3", "1e300")),
    ("snapped_at, soon", *rule(S, "snapped_at", "1.2", "100")),
    ("as good as at rest, never", "scene/scene.c", "as_good_as_at_rest = 1e-5;", "as_good_as_at_rest = 0;"),
    ("as good as at rest, soon", "scene/scene.c", "as_good_as_at_rest = 1e-5;", "as_good_as_at_rest = 1e-2;"),
    ("a start that snaps, as others", C, "self->again > 0 && self->snaps)", "0)"),
    ("the history's clock not kept", C, "self->late = step - (f->now - before);", "self->late = 0;"),
    ("progress, of time alone", "tasks/grow.c", "(1 + speed / grow_rule.motion_counts)", "1"),
    ("turns may not jump", C, "? !self->placed && !(", "? 1 && !("),
    ("what nothing holds may not jump", C, "self->unheld && ts", "0 && ts"),
    ("the last step, of a run that goes on", C, "PetscMin(left, end - ts->ptime)", "left"),
    ("contact never gets firm", "rod/ask.c", "    if (ContactGetsFirm(contact, deepest)) *firm = PETSC_TRUE;", "    (void)deepest;"),
    # -- what snaps and sticking need of friction
    ("next to exact, never", "scene/scene.c", "if (self->growth->rests || self->growth->yield > 0) LoadNextToExact(&self->load);", ""),
    ("told from rest, nothing", "world/load.c", "if (load->limit) load->friction.beta = PetscMax", "if (0) load->friction.beta = PetscMax"),
    # -- contact: where it sets in, and what a rod without a thickness is behind
    ("part_smooth, little", "world/contact.c", "part_smooth = 2;", "part_smooth = 0.2;"),
    ("part_smooth, much", "world/contact.c", "part_smooth = 2;", "part_smooth = 20;"),
    ("lengths_behind, few", *rule(R, "lengths_behind", "4", "0.5")),
    ("lengths_behind, any", *rule(R, "lengths_behind", "4", "1e9")),
    ("feet in space, no kink", "rod/space.c", "  for (int i = 0; i < 4; i++) r[P + i] -= K[i];\n", ""),
    ("feet in space, whatever the slant", "rod/feet_find.c", "foot->rho = RhoOf(foot, touch);",
     "foot->rho = ContactRidgeSmallest(look->contact, foot->item, &(PetscReal){0});"),
    ("feet in space, not remembered", "rod/space.c", "    rod->memory += FrictionDualReals(RUBS) * WALL_SLOTS;\n", ""),
    ("feet in space, as loads of the estimate", "rod/space_defect.c", "if (j % 2) bare[N + d] -=", "if (0) bare[N + d] -="),
    # -- what moves as given in time
    ("comes and goes in a step", C, "if (self->next_end && !self->fixed)", "if (0)"),
    ("tables that turn back unseen", "base/turns.h", "if (behind != before) at[k]", "if (0) at[k]"),
    ("the tip's path left out", "scene/scene.c", "next = SmallerOf(next, TipNextTurn(&scene->tip, t));", ";"),
    ("sets out before it does", "base/schedule.c", " || (t == self->t[0] && t > 0)", ""),
    ("turns back between rows, unseen", "base/schedule.c", "self->value[i] * self->value[i + 1] < 0", "0"),
    ("rests, but for a start", "base/schedule.c", "return Place(self, t) - self->start;", "return Place(self, t);"),
    # -- what is changed in a run
    ("errors followed in the scene of before", "tasks/grow_changes.c", "PetscCall(EstimateSceneChanged(self->estimate));", ";"),
    ("looked up where it was", "scene/change.c", "asked->t, by, x));\n  PetscCall(SurfacesIndexAnew(surfaces));",
     "asked->t, by, x));"),
    # -- what is steered, or fed by a schedule
    ("behind a kink as before", C, "  SetOutAnew(ts, self, f);", ""),
    ("steered, but not in time", "material/curvature.c", "if (k_t) *k_t += rate + at_t * slope;", "if (k_t) *k_t += at_t * slope;"),
    ("steered along with what slides", "material/curvature.c", "if (k_t) *k_t += rate + at_t * slope;", "if (k_t) *k_t += rate;"),
    ("steering costs nothing", "record/balance.c", "seen->wall_power + seen->curvature_power +", "seen->wall_power +"),
    ("slides in, but not out", "material/growth_path.c", "return (1 - s) * SpeedPath(self, s, t);",
     "return (1 - s) * PetscAbsReal(SpeedPath(self, s, t));"),
    ("a path has no turns", "material/growth_path.c", "self->next_turn = NextTurn;", ""),
    ("steered from nothing", *rule(S, "steering_floor", "1e-6", "0")),
    # -- the estimate
    ("estimate: least cells", *rule(S, "estimate_least_cells", "8", "64")),
    ("estimate: cells", *rule(S, "estimate_cells", "48", "8")),
    ("estimate: seldom", *rule(S, "estimate_every", "4", "40")),
    ("estimate: defects", *rule(S, "defects_every", "2", "40")),
    ("estimate: longest", *rule(S, "estimate_longest", "0.8", "8")),
    ("estimate: straight", *rule(S, "estimate_straight", "0.3", "30")),
    ("estimate: early", *rule(S, "estimate_early", "0.01", "0")),
    ("estimate: nudge", *rule(S, "derivative_step", "1e-3", "1")),
    ("to which side, not asked", *rule(G, "reason_grown", "100", "1e100")),
    ("estimate: most folds", *rule(S, "estimate_change", "30", "0.3")),
]

LABELS = "unit|scene"
TARGETS = ("tendril test_vbdf test_lost test_guard test_restart test_observe test_contact test_space test_strands_space "
           "test_friction test_crawl test_grow_errors test_grow_stuck test_schedule test_actuation").split()
LEFT_OUT = ("base-(spline|even|band|blocks|bends|blocklu|chain|elimination|table|options|hdf|handout)|world-(field|surfaces|shapes)|"
            "material-(mesh|shape|growth)|record-event|rod-rod|straight-straight|tasks-(critical|stability)|stability|"
            "world-(critical|the-clamp|several|a-restart)|space-|in-tube-|tubes-|oblique-|laboratory-|sweep-|friction-each-scene|.*-on-[23]$")
SECONDS = 20  # of tests at a time: who shares the machine wants to have a turn


def sh(command, through=(), **more):
    return subprocess.run([*through, *command], capture_output=True, text=True, **more)


def build_command(copy):
    return ["cmake", "--build", str(copy / "build"), "--parallel", "2", "--target", *TARGETS]


def prepare(scratch, through):
    """A copy of what is tracked, and its build."""
    copy = scratch / "copy"
    for name in sh(["git", "ls-files"], cwd=ROOT, check=True).stdout.split("\n"):
        if name and (ROOT / name).is_file():
            source, to = (ROOT / name).read_bytes(), copy / name
            if not to.exists() or to.read_bytes() != source:  # what has not changed is not built again
                to.parent.mkdir(parents=True, exist_ok=True)
                to.write_bytes(source)
                shutil.copymode(ROOT / name, to)
    if not (copy / "build/CMakeCache.txt").exists():
        sh(["cmake", "-S", str(copy), "-B", str(copy / "build"), f"-DPython3_EXECUTABLE={ROOT}/.venv/bin/python"],
           check=True)
    done = sh(build_command(copy), through)
    if done.returncode:
        sys.exit(f"mutations: does not build unchanged: {(done.stdout + done.stderr)[-400:]}")
    return copy


def run_tests(copy, tests, through):
    """Runs tests until one fails: whether that was so, and the seconds that each took."""
    chosen = "^(" + "|".join(map(re.escape, tests)) + ")$"
    done = sh(["ctest", "--test-dir", str(copy / "build"), "--stop-on-failure", "-R", chosen], through)
    ran = re.findall(r"Test +#\d+: (\S+) \.+(.*?) ([\d.]+) sec", done.stdout)
    return {name: float(seconds) for name, _, seconds in ran}, [name for name, end, _ in ran if "Passed" not in end]


def times_of_tests(copy, scratch, wanted, longest, through):
    """How long each test takes that may be used, which must all pass; kept from run to run."""
    listed = sh(["ctest", "--test-dir", str(copy / "build"), "-N", "-L", LABELS], check=True).stdout
    names = [n for n in re.findall(r"Test +#\d+: (\S+)", listed)
             if re.search(wanted, n) and not re.match(f"({LEFT_OUT})", n)]
    kept = scratch / "times.csv"
    times = {name: float(t) for name, t in csv.reader(kept.open())} if kept.exists() else {}
    for name in names:
        if name not in times:
            ran, failed = run_tests(copy, [name], through)
            if failed or name not in ran:
                print(f"{name} fails unchanged, and is left out", flush=True)
            times[name] = 1e9 if failed or name not in ran else ran[name]
            with kept.open("w", newline="") as out:
                csv.writer(out).writerows(times.items())
    return {name: times[name] for name in names if times[name] <= longest}


def first_to_fail(copy, times, noticed, through):
    """Builds, and runs the tests, some at a time, until one fails: its name, or None. First what takes little
    time for what it has noticed."""
    if sh(build_command(copy), through).returncode:
        return "does not build"
    tests = sorted(times, key=lambda name: (0.2 + times[name]) / (0.2 + noticed[name]))
    while tests:
        some = 1
        while some < len(tests) and sum(times[name] for name in tests[:some]) < SECONDS:
            some += 1
        _, failed = run_tests(copy, tests[:some], through)
        if failed:
            return failed[0]
        tests = tests[some:]
    return None


def misplaced():
    """The mutations whose text does not stand just once in its file."""
    for name, file, old, _ in MUTATIONS:
        count = (ROOT / "src" / file).read_text().count(old)
        if count != 1:
            yield f"{name}: stands {count} times in {file}, not once: {old}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scratch", type=Path)
    parser.add_argument("--only", default="")
    parser.add_argument("--tests", default="")
    parser.add_argument("--longest", type=float, default=20)
    parser.add_argument("--through", default="", type=shlex.split)
    parser.add_argument("--again", action="store_true")
    a = parser.parse_args()
    for fault in misplaced():
        sys.exit(f"mutations: {fault}")
    copy = prepare(a.scratch, a.through)
    found = a.scratch / "found.csv"
    known = dict(csv.reader(found.open())) if found.exists() else {}
    times = times_of_tests(copy, a.scratch, a.tests, a.longest, a.through)
    noticed, survivors = collections.Counter(known.values()), []
    for name, file, old, new in MUTATIONS:
        if not re.search(a.only, name):
            continue
        if a.again or name not in known:
            path = copy / "src" / file
            source = path.read_text()
            try:
                path.write_text(source.replace(old, new))
                known[name] = first_to_fail(copy, times, noticed, a.through) or ""
                noticed[known[name]] += 1
            finally:
                path.write_text(source)
            with found.open("w", newline="") as out:
                csv.writer(out).writerows(known.items())
        print(f"{name:45}", known[name] or "SURVIVES", flush=True)
        if not known[name]:
            survivors.append(name)
    print(f"{len(survivors)} noticed by no test: " + "; ".join(survivors))
    return len(survivors) > 0


if __name__ == "__main__":
    sys.exit(main())
