#!/usr/bin/env bash
# Makes a growth table from a rate of elongation in space: scripts/growth_table.sh -h tells how.
set -euo pipefail
# shellcheck source-path=SCRIPTDIR
source "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/python.sh"
command_of growth_table "$@"
