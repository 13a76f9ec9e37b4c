#!/usr/bin/env bash
# Draws result files, one column a file, as PNG and PDF: scripts/plot.sh -h tells how.
set -euo pipefail
here=$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")
PYTHONPATH=$here exec "${PYTHON:-$here/../.venv/bin/python}" -m tendril.plot "$@"
