#!/usr/bin/env bash
# What the peers need: PyElastica, MuJoCo and Exudyn from PyPI in a venv of its own, results/peers/venv.
# (paper_fem.py needs Debian's python3-dolfin.)
#   scripts/lab/peers/setup.sh
set -euo pipefail
# shellcheck source-path=SCRIPTDIR
source "$(dirname "${BASH_SOURCE[0]}")/../../common.sh"

venv=results/peers/venv
mkdir -p results/peers
[ -x $venv/bin/python ] || python3 -m venv $venv
logged results/peers/setup.log "pip" $venv/bin/pip install --quiet pyelastica==1.0.0 mujoco==3.3.7 exudyn==1.13.6 scipy
/usr/bin/python3 -c 'import dolfin' 2>/dev/null ||
  echo "setup: no dolfin for /usr/bin/python3: apt install python3-dolfin, or leave out paper_fem" \
    >&2
