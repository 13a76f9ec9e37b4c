#!/usr/bin/env bash
# Makes a surface for -wall_file from a mesh or a centre line: scripts/surface.sh -h tells how.
set -euo pipefail
# shellcheck source-path=SCRIPTDIR
source "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/python.sh"
command_of surface "$@"
