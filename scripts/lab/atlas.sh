#!/usr/bin/env bash
# The atlas of failure: runs the grid (what is not yet in the store), writes docs/notes/atlas.csv and draws
# docs/notes/atlas.png and docs/notes/atlas-profile.png (and .pdf).
#   scripts/lab/atlas.sh [--quick] [OPTIONS OF atlas.py]
# --quick: fewer cells, into results/atlas-quick, for a look. Stopped, it goes on where it was.
# TENDRIL names the executable (build/tendril). Peers: scripts/lab/peers/setup.sh first, or they show as
# not supported.
set -euo pipefail
# shellcheck source-path=SCRIPTDIR
source "$(dirname "${BASH_SOURCE[0]}")/../common.sh"

[ -x .venv/bin/python ] || scripts/setup.sh
if [ -z "${TENDRIL:-}" ]; then build build tendril; fi
exec .venv/bin/python scripts/lab/atlas.py "$@"
