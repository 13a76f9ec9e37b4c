# Shared by the scripts that are commands of the Python package (sourced): command_of NAME WORDS...
# runs it in the directory one is in.
# shellcheck shell=bash
command_of() {
  local here
  here=$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")
  TENDRIL_SCRIPT=1 PYTHONPATH=$here${PYTHONPATH:+:$PYTHONPATH} exec "${PYTHON:-$here/../.venv/bin/python}" -m tendril "$@"
}
