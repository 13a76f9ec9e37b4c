#!/usr/bin/env bash
# Measures speed beside accuracy and writes docs/notes/bench.md: the dry rod and the short rod beside the
# paper's finite elements (if Debian's package fenics is there), friction to the limit, one Newton
# iteration beside LAPACK's band solver. About 5 minutes.
#   scripts/lab/bench.sh
set -euo pipefail
# shellcheck source-path=SCRIPTDIR
source "$(dirname "${BASH_SOURCE[0]}")/../common.sh"

scripts/setup.sh
build build tendril
build build bench_newton
.venv/bin/python scripts/lab/bench.py
