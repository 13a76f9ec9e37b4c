#!/usr/bin/env bash
# Makes a film of a result file: scripts/animate.sh -h tells how.
set -euo pipefail
# shellcheck source-path=SCRIPTDIR
source "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/python.sh"
command_of animate "$@"
