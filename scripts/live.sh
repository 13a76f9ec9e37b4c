#!/usr/bin/env bash
# Runs a scene that one can touch, in a browser: scripts/live.sh -h tells how.
set -euo pipefail
# shellcheck source-path=SCRIPTDIR
source "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/python.sh"
python=${PYTHON:-$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/../.venv/bin/python}
if ! "$python" -c 'import websockets.asyncio' 2>/dev/null; then
  echo "live: installing the library websockets" >&2
  "$python" -m pip install --disable-pip-version-check -q 'websockets>=13' >&2
fi
command_of live "$@"
