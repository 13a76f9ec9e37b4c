#!/usr/bin/env bash
# Fits options of a scene to what was measured: scripts/fit.sh -h tells how.
set -euo pipefail
# shellcheck source-path=SCRIPTDIR
source "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/python.sh"
command_of fit "$@"
