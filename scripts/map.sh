#!/usr/bin/env bash
# Draws a map over a sweep: scripts/map.sh -h tells how.
set -euo pipefail
# shellcheck source-path=SCRIPTDIR
source "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/python.sh"
command_of map "$@"
