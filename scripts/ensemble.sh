#!/usr/bin/env bash
# An ensemble over seeds of a random natural curvature, and its distributions drawn.
#   scripts/ensemble.sh [MEMBERS] [OPTIONS ...]      200 fed tubes, grown to length 20, if not told
# Leaves results/ensemble/*.h5, results/ensemble.png and .pdf where one is. Goes on where it was stopped; other
# options need another DIRECTORY: ENSEMBLE=results/wet scripts/ensemble.sh 50 -friction_mu 0
set -euo pipefail
# shellcheck source-path=SCRIPTDIR
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

members=${1:-200}
[[ $members =~ ^[1-9][0-9]*$ ]] || fail "$members: give the number of members first"
shift || true
directory=${ENSEMBLE:-results/ensemble}
python=${PYTHON:-$root/.venv/bin/python}
cd "$started"
# 200 cells: the shapes of a single member differ from those of 500 by less than a line's width
"$root/scripts/sweep.sh" "$directory" -options_file "$root/options/pushed-tube.opts" -stop_length 20 -rod_cells 200 \
  -ts_rtol 1e-5 -output_interval 19.5 -quiet "$@" -- rod_curvature_seed "1:$members:$members"
"$python" -m tendril ensemble "$directory" --output "$directory"
