"""Runs what scripts/lab/bench.sh measures and writes it as one page of tables (docs/notes/bench.md).

Every time stands beside its error, measured in the same run. Times are the best of a few runs, for
machines are noisy; quote their ratios. TENDRIL_BEFORE=PROGRAM and BENCH_BEFORE=ITS_BENCH_NEWTON in the
environment put an earlier version beside this one."""
import datetime
import json
import math
import os
import re
import resource
import subprocess
import sys
import time

import numpy as np

from tendril import load

TENDRIL, BENCH = "build/tendril", "build/bench_newton"
BEFORE = os.environ.get("TENDRIL_BEFORE")  # an earlier version, to stand beside this one
BENCH_BEFORE = os.environ.get("BENCH_BEFORE")  # and its bench_newton
WORK = "results/bench"
REFERENCE = "tests/reference"
SHORT = "-growth_initial_length 2 -shape_amplitude 0.1"
DRY = "-options_file options/uniform-dry.opts"


def run(options, output, repeat=3, program=TENDRIL):
    """Best wall time of the run (its own clock), Newton iterations, steps and the results."""
    best = math.inf
    for _ in range(repeat):
        done = subprocess.run([program, *options.split(), "-output", output], capture_output=True, text=True)
        if done.returncode:
            return None
        found = re.search(r"(\d+) steps, \d+ rejected, (\d+) Newton iterations, ([\d.]+) s", done.stdout)
        steps, iterations, seconds = int(found[1]), int(found[2]), float(found[3])
        best = min(best, seconds)
    return best, iterations, steps, load(output)


def reference(name):
    with open(f"{REFERENCE}/{name}.json") as lines:
        return {entry["t"]: entry for entry in map(json.loads, filter(str.strip, lines))}


def norm_error(results, entries, times):
    """Largest relative error of the norm, by Simpson's rule on the stored shapes (uniform growth)."""
    s, errors = results.shapes.s, []
    for t in times:
        k = int(np.argmin(abs(results.shapes.t - t)))
        y, slope, h = results.shapes.x[k, :, 1], entries[t]["length"] * np.sin(results.shapes.theta[k]), np.diff(s)
        mid = (y[:-1] + y[1:]) / 2 + h / 8 * (slope[:-1] - slope[1:])
        norm = np.sqrt(np.sum(h / 6 * (y[:-1] ** 2 + 4 * mid ** 2 + y[1:] ** 2)))
        errors.append(abs(norm / entries[t]["norm_x2"] - 1))
    return max(errors)


def distance(tip, entry):
    return np.linalg.norm(np.array(tip) - entry) / np.linalg.norm(entry)


def tip_error(results, entries, times):
    at = [int(np.argmin(abs(results.shapes.t - t))) for t in times]
    return max(distance(results.shapes.x[k, -1], entries[t]["tip"]) for k, t in zip(at, times))


def finite_elements(peer, options, times):
    """Seconds of the peer's own loop, and what it found at the times."""
    done = subprocess.run([*peer, *options.split(), "-times", ",".join(map(str, times))], capture_output=True, text=True, check=True)
    lines = [json.loads(line) for line in done.stdout.splitlines() if line.startswith("{")]  # (or it says what it compiles)
    return lines[-1]["seconds"], {line["t"]: line for line in lines[:-1]}


def table(out, head, rows):
    out.append("| " + " | ".join(head) + " |")
    out.append("|" + "---|" * len(head))
    out.extend("| " + " | ".join(row) + " |" for row in rows)
    out.append("")


def dry_rod(out, peer):
    """The whole dry rod to t = 40, and the finite elements of the paper beside it."""
    entries = reference("v_decay_mu1")
    rows, times = [], {}
    before = [("version 0.1, defaults", "", BEFORE), ("version 0.1, -ts_rtol 2e-8", "-ts_rtol 2e-8", BEFORE)] if BEFORE else []
    for title, options, program in [
        ("frame, defaults", "", TENDRIL),
        ("auto, defaults", "-rod_model auto", TENDRIL),
        ("frame, -ts_rtol 2e-8", "-ts_rtol 2e-8", TENDRIL),
        ("auto, -ts_rtol 2e-8", "-rod_model auto -ts_rtol 2e-8", TENDRIL),
        *before,
        ("mixed, N = 2000", "-rod_model mixed -rod_cells 2000", TENDRIL),
    ]:
        seconds, iterations, steps, results = run(f"{DRY} {options}", f"{WORK}/dry.h5", program=program)
        times[title] = seconds
        rows.append([title, f"{seconds:.2f}", str(steps), str(iterations), f"{norm_error(results, entries, [1.5, 8, 12]):.1e}",
                     f"{tip_error(results, entries, [15, 20, 30, 40]):.1e}", f"{results.series.energy_defect[-1]:.0e}"])
    for nel in (64, 500) if peer else ():
        seconds, found = finite_elements(peer, f"-nel {nel} -dt 0.01 -ts_max_time 40", [1.5, 8, 12, 15, 20, 30, 40])
        times[f"fem {nel}"] = seconds
        rows.append([f"the paper's finite elements, {nel} cells, dt 0.01", f"{seconds:.1f}", "4000", "",
                     f"{max(abs(found[t]['norm_x2'] / entries[t]['norm_x2'] - 1) for t in (1.5, 8, 12)):.1e}",
                     f"{max(distance(found[t]['tip'], entries[t]['tip']) for t in (15, 20, 30, 40)):.1e}", ""])
    out.append("## The dry rod to t = 40 (options/uniform-dry.opts), one core\n")
    out.append("Error of the norm of x2: largest at t = 1.5, 8, 12; of the tip: largest at t = 15, 20, 30, 40; relative to the reference.\n")
    table(out, ["method", "seconds", "steps", "Newton", "error of norm", "error of tip", "energy defect"], rows)
    if "fem 64" in times:
        out.append(f"The finite elements (64 cells) take {times['fem 64'] / times['frame, defaults']:.0f} times as long as the frame model "
                   f"with defaults and {times['fem 64'] / times['auto, -ts_rtol 2e-8']:.0f} times as long as auto at 2e-8.\n")


def short_rod(out, peer):
    """v_short: the time for a tip good to 1e-5, ours measured, the peer's extrapolated if need be."""
    entries = reference("v_short")
    rows = []
    ours = None
    for options in ("-ts_rtol 1e-5 -rod_cells 100", "-ts_rtol 3e-6 -rod_cells 150", "-ts_rtol 1e-6 -rod_cells 200", ""):
        seconds, iterations, steps, results = run(f"{SHORT} -ts_max_time 5 -output_interval 1 {options}", f"{WORK}/short.h5", 5)
        error = tip_error(results, entries, [1, 5])
        if error < 1e-5 and (ours is None or seconds < ours):
            ours = seconds
        rows.append([f"frame {options or 'defaults'}", f"{seconds:.4f}", str(steps), f"{error:.1e}"])
    last = None
    for dt in (0.02, 0.01, 0.005, 0.0025) if peer else ():
        seconds, found = finite_elements(peer, f"{SHORT} -nel 64 -dt {dt} -ts_max_time 5", [1, 5])
        error = max(distance(found[t]["tip"], entries[t]["tip"]) for t in (1, 5))
        rows.append([f"the paper's finite elements, 64 cells, dt {dt}", f"{seconds:.2f}", str(round(5 / dt)), f"{error:.1e}"])
        last = seconds, error
    out.append("## The short rod (L0 = 2, sag 0.1, to t = 5): error of the tip, largest at t = 1 and 5\n")
    table(out, ["method", "seconds", "steps", "error of tip"], rows)
    if last:
        need = last[0] * last[1] / 1e-5
        out.append(f"For an error of 1e-5 the finite elements, of first order in time, would need {need:.0f} s (extrapolated from their "
                   f"finest run); ours needs {ours:.3f} s (measured): a factor of {need / ours:.0f}.\n")


def friction_limit(out):
    """beta from 1e-2 to exact Coulomb friction."""
    rows, tips = [], {}
    betas = ["1e-2", "1e-3", "1e-4", "1e-5", "1e-6", "1e-7", "1e-8", "1e-9", "1e-10", "1e-11", "1e-12", "0"]
    runs = {}
    for beta in betas:
        runs[beta] = [run(f"{SHORT} -ts_max_time {end} -friction_beta {beta}", f"{WORK}/beta.h5", 1) for end in (5, 32)]
        tips[beta] = [np.array(r[3].shapes.x[-1, -1]) if r else None for r in runs[beta]]
    for beta in betas:
        row = [beta]
        for k in (0, 1):
            if runs[beta][k] is None:
                row += ["failed"] * 3
                continue
            seconds, iterations, steps, _ = runs[beta][k]
            row += [f"{iterations / steps:.2f}", f"{seconds:.2f}", f"{np.linalg.norm(tips[beta][k] - tips['0'][k]):.1e}" if beta != "0" else "-"]
        rows.append(row)
    out.append("## Friction to the limit: L0 = 2, sag 0.1, to t = 5 and folded to t = 32, no other option changed\n")
    table(out, ["beta", "Newton per step, t = 5", "seconds", "tip against beta = 0", "Newton per step, t = 32", "seconds", "tip against beta = 0"], rows)


def drift(out):
    """Does the free end of the folded dry rod drift because of beta? And where does a rod stand still?"""
    rows = []
    for beta in ("1e-3", "1e-6", "1e-10", "0"):
        _, _, _, results = run(f"{SHORT} -ts_max_time 60 -output_interval 10 -friction_beta {beta}", f"{WORK}/drift.h5", 1)
        x = {t: results.shapes.x[int(np.argmin(abs(results.shapes.t - t))), -1, 0] for t in (20, 40, 50, 60)}
        _, _, _, fed = run(f"-options_file options/feed.opts -ts_max_time 16 -friction_beta {beta}", f"{WORK}/drift.h5", 1)
        rows.append([beta, *(f"{x[t]:.3f}" for t in x), *(f"{fed.value('tip_speed', t):.1e}" for t in (8, 12, 16))])
    out.append("## Creep and stick\n")
    out.append("x1 of the tip of the folded, uniformly growing dry rod, and speed of the tip of the fed rod after it has folded. The drift of the "
               "first is the same without any regularisation: growth goes on at the tip itself. The second truly stands still: a regularised law "
               "lets it creep at about sqrt(beta), exact Coulomb friction holds it.\n")
    table(out, ["beta", "tip x1, t = 20", "40", "50", "60", "fed: speed, t = 8", "12", "16"], rows)


def launched(ranks):
    """What stands before a program that runs on so many ranks."""
    return ["mpiexec", "-n", str(ranks)] if ranks > 1 else []


def numbers_of(program, arguments, ranks=1):
    """What bench_newton prints: cells, ranks, times, difference; of a joint ranks and time."""
    command = [*launched(ranks), program, *arguments]
    return [float(word) for word in subprocess.run(command, capture_output=True, text=True, check=True).stdout.split()]


def newton(out, repeat=5):
    """One Newton iteration against LAPACK's band solver: the best of a few runs, in turn."""
    rows = []
    for cells, ranks in ((500, 1), (5000, 1), (50000, 1), (500000, 1), (500000, 2)):
        arguments = ["-rod_cells", str(cells), "-bench_repeat", "5" if cells > 1e5 else "30"]
        runs, before = [], []
        for _ in range(repeat):
            runs.append(numbers_of(BENCH, arguments, ranks))
            if BENCH_BEFORE:
                before.append(numbers_of(BENCH_BEFORE, arguments, ranks)[6])
        best = min(runs, key=lambda words: words[5])
        assembled, band = min(words[6] for words in runs), min(words[7] for words in runs)
        rows.append([str(cells), str(ranks), *(f"{time:.3f}" for time in best[2:6]), f"{assembled:.3f}", f"{min(before):.3f}" if before else "-",
                     f"{band:.3f}" if band else "-", f"{best[5] / band:.2f}" if band else "-", f"{best[8]:.1e}"])
    out.append("## One Newton iteration of the frame model, microseconds per node\n")
    out.append("The Jacobian is computed and eliminated in one pass; beside it the same iteration with an assembled matrix and PETSc's block LU, "
               f"that of version 0.1, and LAPACK's band solver alone; each the best of {repeat}.\n")
    table(out, ["N", "ranks", "residual", "Jacobian and elimination", "solve", "all", "assembled, all", "version 0.1, all", "dgbsv", "all / dgbsv",
                "difference to the assembled"], rows)


def joint(out):
    """What joins many ranks."""
    rows = []
    for ranks in (2, 4, 16, 64, 256, 1024):
        _, microseconds = numbers_of(BENCH, ["-bench_joint", str(ranks), "-bench_repeat", "1000"])
        rows.append([str(ranks), f"{microseconds:.2f}", f"{microseconds / ranks:.3f}"])
    out.append("## What joins P ranks: microseconds that each spends on it in an iteration, beside the message of 54 numbers a rank\n")
    table(out, ["P", "microseconds", "a rank"], rows)


def core_seconds(command):
    """Seconds of all cores that a command and its children take, and those of the clock."""
    def spent():
        use = resource.getrusage(resource.RUSAGE_CHILDREN)
        return use.ru_utime + use.ru_stime
    before, begin = spent(), time.perf_counter()
    subprocess.run(command, capture_output=True, check=True)
    return spent() - before, time.perf_counter() - begin


def ensemble(out, members=100):
    """Members of scripts/ensemble.sh as one job, and as a process each."""
    scene = "-options_file options/pushed-tube.opts -stop_length 20 -rod_cells 200 -ts_rtol 1e-5 -output_interval 19.5 -quiet".split()
    table_file, file = f"{WORK}/members.csv", f"{WORK}/members.h5"
    with open(table_file, "w") as lines:
        lines.write("\n".join(["rod_curvature_seed", *map(str, range(1, members + 1))]) + "\n")

    def sweep(ranks):
        if os.path.exists(file):
            os.remove(file)
        return [*launched(ranks), TENDRIL, *scene, "-task", "sweep", "-sweep_file", table_file, "-output", file]

    def single(program, seed):
        return core_seconds([program, *scene, "-rod_curvature_seed", str(seed), "-output", f"{WORK}/member.h5"])

    found = [("sweep, one rank", core_seconds(sweep(1))), ("sweep, two ranks", core_seconds(sweep(2)))]
    for title, program in [("a process each", TENDRIL)] + ([("a process each, version 0.1", BEFORE)] if BEFORE else []):
        runs = [single(program, seed) for seed in range(1, members + 1)]
        found.append((title, [sum(column) for column in zip(*runs)]))
    out.append("## Many runs in one job\n")
    out.append(f"{members} tubes of scripts/ensemble.sh, each with random bends of its own, grown to length 20: seconds a member.\n")
    table(out, ["", "seconds of all cores", "of the clock", "of all cores, over the last row's"],
          [[title, f"{cores / members:.3f}", f"{clock / members:.3f}", f"{cores / found[-1][1][0]:.2f}"] for title, (cores, clock) in found])


def main():
    os.makedirs(WORK, exist_ok=True)
    os.makedirs("docs/notes", exist_ok=True)
    peer = None
    if os.path.exists("scripts/lab/peers/paper_fem.py") and not subprocess.run(["/usr/bin/python3", "-c", "import dolfin"], capture_output=True).returncode:
        peer = ["/usr/bin/python3", "scripts/lab/peers/paper_fem.py"]
    else:
        print("bench: without the finite elements of the paper (Debian's package fenics is not there)")
    with open("/proc/cpuinfo") as info:
        cpu = re.search(r"model name\s*: (.*)", info.read())
    out = [f"# Speed, as measured on {datetime.date.today():%d %B %Y}", "", f"By scripts/lab/bench.sh on {os.cpu_count()} cores, {cpu[1] if cpu else 'unknown CPU'}. Ratios travel further than seconds.", ""]
    for part in (lambda: dry_rod(out, peer), lambda: short_rod(out, peer), lambda: friction_limit(out), lambda: drift(out), lambda: newton(out), lambda: joint(out),
                 lambda: ensemble(out)):
        part()
        with open("docs/notes/bench.md", "w") as page:
            page.write("\n".join(out))
    print("bench: docs/notes/bench.md holds the tables")


if __name__ == "__main__":
    main()
