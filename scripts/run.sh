#!/usr/bin/env bash
# From nothing to a result and its picture: sets up, builds, runs scenes and draws them.
#   scripts/run.sh [SCENE ...]     a scene is an options file, or the name of one in options/
# Leaves results/SCENE.h5, .png and .pdf in the directory one is in.
set -euo pipefail
# shellcheck source-path=SCRIPTDIR
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

if [ $# = 0 ]; then set -- uniform-dry; fi
scenes=()
for scene in "$@"; do
  file=$scene
  [[ $file == /* ]] || file=$started/$scene
  if [ ! -f "$file" ]; then file=$root/options/$scene.opts; fi
  if [ ! -f "$file" ]; then
    known=(options/*.opts)
    known=("${known[@]##*/}")
    fail "no options file $scene here, and no scene of that name; there are ${known[*]%.opts}"
  fi
  scenes+=("$file")
done

scripts/setup.sh
echo "run: building build/tendril"
build build tendril
cd "$started"
mkdir -p results
for file in "${scenes[@]}"; do
  name=$(basename "$file" .opts)
  echo "run: growing $name, $file"
  mpiexec -n 1 --bind-to none "$root/build/tendril" -options_file "$file" -output "results/$name.h5"
  "$root/.venv/bin/python" -m tendril plot "results/$name.h5" --output "results/$name"
  echo "run: results/$name.h5 holds the result"
done
