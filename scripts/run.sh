#!/usr/bin/env bash
# From nothing to a result and its picture: sets up, builds, runs scenes and draws them.
#   scripts/run.sh [SCENE ...]     a scene is a name in options/, or an options file
set -euo pipefail
# shellcheck source-path=SCRIPTDIR
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

if [ $# = 0 ]; then set -- uniform-dry; fi
scenes=()
for scene in "$@"; do
  file=options/$scene.opts
  if [ ! -f "$file" ]; then file=$scene; fi
  if [ ! -f "$file" ]; then
    known=(options/*.opts)
    known=("${known[@]##*/}")
    fail "no scene $scene; there are ${known[*]%.opts}"
  fi
  scenes+=("$file")
done

scripts/setup.sh
echo "run: building build/tendril"
build build tendril
mkdir -p results
for file in "${scenes[@]}"; do
  name=$(basename "$file" .opts)
  echo "run: growing $file"
  mpiexec -n 1 --bind-to none build/tendril -options_file "$file" -output "results/$name.h5"
  .venv/bin/python -m tendril plot "results/$name.h5" --output "results/$name"
  echo "run: results/$name.h5 holds the result, results/$name.png and .pdf show it"
done
