#!/usr/bin/env bash
# Takes a rod elsewhere, to VTK or as a mesh: scripts/export.sh -h tells how.
set -euo pipefail
# shellcheck source-path=SCRIPTDIR
source "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/python.sh"
command_of export "$@"
