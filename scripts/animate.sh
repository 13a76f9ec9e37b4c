#!/usr/bin/env bash
# Makes a film of a result file: scripts/animate.sh -h tells how.
set -euo pipefail
here=$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")
PYTHONPATH=$here exec "${PYTHON:-$here/../.venv/bin/python}" -m tendril.animate "$@"
