#!/usr/bin/env bash
# From nothing to tested: sets up, builds, runs all tests, as many at a time as there are cores.
# TENDRIL_WERROR=ON makes warnings errors, as the project's own checks do.
#   scripts/test.sh [CTEST OPTIONS]     e.g. -R growth, only the tests named so
set -euo pipefail
# shellcheck source-path=SCRIPTDIR
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

scripts/setup.sh tests
# what only tests need comes while the rest is built
{
  .venv/bin/python -c "import vtkmodules, nbclient, ipykernel, trimesh, websockets" 2>/dev/null ||
    .venv/bin/python -m pip install --disable-pip-version-check -q -r tests/requirements.txt ||
    echo "test: tests/requirements.txt cannot be had: the test of ParaView will be left out"
} &
echo "test: building build-test/"
build build-test all -DTENDRIL_WERROR="${TENDRIL_WERROR:-OFF}" -DPython3_EXECUTABLE="$PWD/.venv/bin/python"
wait
# one more than there are cores: some wait, for a browser or for a process that is held
ctest --test-dir build-test --output-on-failure --parallel "$(($(cores) + 1))" "$@" && status=0 || status=$?
.venv/bin/python -c 'import sys; sys.path.insert(0, "tests/support"); import chromium; chromium.FOUND or print("test: pages were", chromium.MISSING)'
exit "$status"
