#!/usr/bin/env bash
# The chart of speed against accuracy: runs the matrix of methods (those not yet in the store), writes
# docs/notes/chart.csv and draws docs/notes/chart.png (and .pdf).
#   scripts/lab/chart.sh [--quick] [OPTIONS OF chart.py]
# --quick: a coarse matrix into results/chart-quick, for a look. Stopped, it goes on where it was.
# TENDRIL names the executable (build/tendril). Peers: scripts/lab/peers/setup.sh first, or they show as
# not supported.
set -euo pipefail
# shellcheck source-path=SCRIPTDIR
source "$(dirname "${BASH_SOURCE[0]}")/../common.sh"

[ -x .venv/bin/python ] || scripts/setup.sh
if [ -z "${TENDRIL:-}" ]; then build build tendril; fi
exec .venv/bin/python scripts/lab/chart.py "$@"
