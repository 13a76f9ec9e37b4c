#!/usr/bin/env bash
# Measures centre lines in a film or photographs: scripts/measure.sh -h tells how.
set -euo pipefail
# shellcheck source-path=SCRIPTDIR
source "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/python.sh"
command_of measure "$@"
