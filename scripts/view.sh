#!/usr/bin/env bash
# Makes one page for a browser of result files: scripts/view.sh -h tells how.
set -euo pipefail
# shellcheck source-path=SCRIPTDIR
source "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/python.sh"
command_of view "$@"
