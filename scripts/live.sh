#!/usr/bin/env bash
# Runs a scene that one can touch, in a browser: scripts/live.sh -h tells how.
set -euo pipefail
# shellcheck source-path=SCRIPTDIR
source "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/python.sh"
command_of live "$@"
