#!/usr/bin/env bash
# Makes a growth table from a rate of elongation in space: scripts/growth_table.sh -h tells how.
set -euo pipefail
here=$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")
PYTHONPATH=$here exec "${PYTHON:-$here/../.venv/bin/python}" -m tendril.growth_table "$@"
