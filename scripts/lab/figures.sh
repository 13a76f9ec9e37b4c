#!/usr/bin/env bash
# Runs what the paper shows and redraws its figures into docs/figures/; docs/notes/paper-figures.md reads them.
#   scripts/lab/figures.sh            finished runs in results/figures are not run again
set -euo pipefail
# shellcheck source-path=SCRIPTDIR
source "$(dirname "${BASH_SOURCE[0]}")/../common.sh"
export OMPI_MCA_ess_singleton_isolated=1
tendril=${TENDRIL:-build/tendril} python=${PYTHON:-.venv/bin/python}
[ -x "$tendril" ] || fail "no executable $tendril; run scripts/setup.sh and build, or set TENDRIL"
d=results/figures pictures=docs/figures
mkdir -p "$d" "$pictures"

grow() { # grow NAME OPTIONS...
  if [ -f "$d/$1.h5" ]; then return; fi
  echo "figures: $1"
  "$tendril" -quiet "${@:2}" -output "$d/$1.part.h5"
  mv "$d/$1.part.h5" "$d/$1.h5"
  rm -f "$d/$1.part.xmf"
}
crossing() { # crossing NAME OPTIONS...: up to where the rod first crosses itself, found as an event
  grow "crossing-$1" "${@:2}" -stop_self_contact 0
}
draw() { # draw PICTURE ARGUMENTS OF PLOT.PY...
  "$python" -m tendril plot "${@:2}" --output "$pictures/$1"
  rm "$pictures/$1.pdf"
}

for mu in 1 0.5 0; do
  grow "uniform-$mu" -options_file options/paper-uniform.opts -friction_mu "$mu"
  grow "uniform-$mu-perfect" -options_file options/paper-uniform.opts -friction_mu "$mu" \
    -rod_curvature 0
done
draw uniform "$d"/uniform-{1,0.5,0}.h5 --panels norm,shapes,normalised --times 10,20,30 \
  --beside "$d/uniform-1-perfect.h5,$d/uniform-0.5-perfect.h5,$d/uniform-0-perfect.h5" \
  --titles '$\mu = 1$,$\mu = 0.5$,$\mu = 0$'
grow folded -options_file options/paper-folded.opts
draw folded "$d/folded.h5" --panels shapes,normalised,distance,speed --times 8,16,24,32
for a in 5 0.5 0.05; do
  grow "gaussian-$a" -options_file options/paper-gaussian.opts -growth_width "$a"
done
draw gaussian "$d"/gaussian-{5,0.5,0.05}.h5 --panels shapes,distance --times 5,10,15,20 \
  --titles '$a = 5$,$a = 0.5$,$a = 0.05$'
for law in feed gaussian; do
  more=(-growth_type "$law" -stop_length 20)
  # a fed tube's natural curvature varies over a length, that of one growing in place over a part of it
  if [ $law = gaussian ]; then more+=(-growth_width 0.05 -rod_curvature_length 0.2); fi
  grow "tube-$law" -options_file options/pushed-tube.opts "${more[@]}"
  crossing "tube-$law" -options_file options/pushed-tube.opts "${more[@]}"
  grow "tube-$law-perfect" -options_file options/pushed-tube.opts "${more[@]}" \
    -rod_curvature_random 0 -shape_type sag -shape_amplitude 0.1
done
for amplitude in 0.01 0.1 1; do
  grow "map-sag-$amplitude" -ts_max_time 40 -output_interval 1 -shape_amplitude "$amplitude"
done
for amplitude in 0.001 0.01 0.1 0.2 0.3; do
  bent=(-ts_max_time 40 -output_interval 1 -shape_type straight)
  for what in grow crossing; do
    "$what" "map-constant-$amplitude" "${bent[@]}" -rod_curvature "$amplitude"
    "$what" "map-random-$amplitude" "${bent[@]}" -rod_curvature_random "$amplitude" \
      -rod_curvature_length 0.2
  done
done
grow packing-coil -growth_type feed -growth_initial_length 0.02 -shape_type straight -rod_curvature 0.1 \
  -contact_self -contact_diameter 0.00333 -contact_stiffness 2e8 -wall_file options/data/coil.txt \
  -rod_cells 700 -ts_rtol 1e-5 -ts_max_time 2.2 -output_interval 0.1
draw packing-coil "$d/packing-coil.h5" --panels touch,feed_force --times 2.2
grow packing-folds -options_file options/packing.opts -ts_max_time 84.3 -rod_cells 700 \
  -contact_stiffness 1e4 -ts_rtol 1e-4 -output_interval 1
draw packing-folds "$d/packing-folds.h5" --panels touch,feed_force --times 84.3
"$python" scripts/lab/figures.py "$d" "$pictures"
ENSEMBLE=$d/ensemble scripts/ensemble.sh 200 # tubes: seeds of natural curvature
cp "$d/ensemble.png" "$pictures/ensemble.png"
