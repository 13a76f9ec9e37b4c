#!/usr/bin/env bash
# Draws result files, a column a file or all in one, as PNG and PDF: scripts/plot.sh -h tells how.
set -euo pipefail
# shellcheck source-path=SCRIPTDIR
source "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/python.sh"
command_of plot "$@"
