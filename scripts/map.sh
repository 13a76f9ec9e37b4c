#!/usr/bin/env bash
# Draws a map over a sweep: scripts/map.sh -h tells how.
set -euo pipefail
here=$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")
PYTHONPATH=$here exec "${PYTHON:-$here/../.venv/bin/python}" -m tendril.map "$@"
