#!/usr/bin/env bash
# Runs every scene of options/ and draws it for options/README.md, into options/pictures/.
#   scripts/lab/gallery.sh
set -euo pipefail
# shellcheck source-path=SCRIPTDIR
source "$(dirname "${BASH_SOURCE[0]}")/../common.sh"

scripts/setup.sh
build build tendril
mkdir -p results options/pictures
.venv/bin/python -m tendril.scene_data
for file in options/*.opts; do
  name=$(basename "$file" .opts)
  echo "gallery: $name"
  mpiexec -n 1 --bind-to none build/tendril -options_file "$file" -output "results/$name.h5" >"results/$name.log"
  case $name in paper-* | pushed-tube) continue ;; esac # drawn by scripts/lab/figures.sh
  case $name in injected-* | duct-bends) continue ;; esac # by scripts/lab/injected_tube.py and duct.py
  case $name in critical-weight | critical-twist | critical-hinged) continue ;; esac # run, not shown
  files=("results/$name.h5") what=()
  if grep -q '^-output_interval' "$file"; then what=(--panels norm,shapes); fi
  case $name in
  root-layers) what=(--panels shapes,force --times 2,4,6,8,10,12) ;;
  vine-stuck) what=(--panels shapes,force --times 0,1,2,4,6,8) ;;
  snake) # beside the rod that slides as hard along as across
    build/tendril -quiet -options_file "$file" -friction_across 1 -output results/snake-1.h5
    files=(results/snake-1.h5 "${files[@]}")
    what=(--panels "norm,shapes" --times 3,6,9,12)
    what+=(--titles "as hard along as across,twice as hard across")
    ;;
  tube-contact) # and further, beside the tube that may cross itself
    build/tendril -quiet -options_file "$file" -ts_max_time 39.5 -output results/tube-contact-40.h5
    build/tendril -quiet -options_file options/pushed-tube.opts -stop_length 56.4cm -output results/tube-crossing.h5
    files=(results/tube-crossing.h5 "${files[@]}" results/tube-contact-40.h5)
    what=(--panels shapes --times 9.5,19.5,39.5 --titles "may cross itself,cannot cross itself,and fed twice as far")
    ;;
  cable-conduit) what=(--panels touch,contact --times 9.6) ;;
  packing) what=(--panels touch,contact --times 27.8) ;;
  root-gel) what=(--panels space,shapes --times 3,4,5,8 --view 20,20) ;;
  vine-maze) # and bent by nature to the other side
    build/tendril -quiet -options_file "$file" -rod_curvature -0.3 -output results/vine-blind.h5
    files+=(results/vine-blind.h5)
    what=(--panels space --times 2,3,4,6.2 --view 20,35 --titles "bent to its left,bent to its right")
    ;;
  vessel-branch) # beside the catheter that is only pushed
    build/tendril -quiet -options_file "$file" -clamp_spin 0 -output results/vessel-pushed.h5
    files=(results/vessel-pushed.h5 "${files[@]}")
    what=(--panels space --times 1,2,3,5 --view 25,20 --titles "pushed,and turned")
    ;;
  tube-heap) # beside the tube whose clamp lies on the table
    build/tendril -quiet -options_file "$file" -wall_file options/data/table.txt -output results/tube-flat.h5
    files=(results/tube-flat.h5 "${files[@]}")
    what=(--panels shapes,side --times 5,10,16 --titles "clamped on the table,clamped above it")
    ;;
  root-stalls) # beside the root whose growth is given
    sed '/^-growth_yield/d' "$file" >results/root-grows.opts
    build/tendril -quiet -options_file results/root-grows.opts -ts_max_time 6.5 -output results/root-grows.h5
    files=(results/root-grows.h5 "${files[@]}")
    what=(--panels shapes,length --times 1,3,5,6.4 --titles "growth is given,growth feels force")
    ;;
  catheter) what=(--panels shapes,force --times 2,4,6,8,10,12) ;;
  root-helix | vine-heavy) what=(--panels space,shapes,curvature,twisting) ;;
  wire-spun) what=(--panels space,shapes,curvature,twisting --times 5,9,14) ;;
  rod-bent) what=(--panels space,norm,curvature,twisting) ;;
  root-laterals) what=(--panels space --times 1 --view 15,25) ;;
  root-born) what=(--panels space --times 30h --view 15,25) ;;
  seedlings) what=(--panels space --times 0.75 --view 30,25) ;;
  against-wall) what=(--panels shapes,contact --times 0.4,0.6,1,4) ;;
  root-stones) what=(--panels shapes --times 1,3,6,10) ;;
  twisted-rod) what=(--panels side,front,curvature,twisting --times 0.05,0.3,0.6,10) ;;
  catheter-steered) what=(--panels shapes,force --times 3.5,5,7.5,10,16) ;;
  vine-steered) what=(--panels shapes,curvature,power --times 4,8,12,15) ;;
  root-gravity) what=(--panels shapes,tip_angle --times 0h,4h,8h,12h,24h) ;;
  root-waving) # beside one on a plate that is nearly upright, and one that is twisted by nature
    build/tendril -quiet -options_file "$file" -tropism_direction 0.966,0,-0.259 -output results/root-upright.h5
    build/tendril -quiet -options_file "$file" -rod_twist 0.5/mm -output results/root-skewed.h5
    files=(results/root-upright.h5 "${files[@]}" results/root-skewed.h5)
    what=(--panels shapes --times 24h,48h --titles "tilted by 15°,by 45°,by 45° and twisted by nature")
    ;;
  root-stone) what=(--panels shapes,length,bends,growth --times 0.6,1.7,2.2,7) ;;
  tendril-post) what=(--panels space,portrait --times 3,8 --view 30,15) ;;
  shoot-light) what=(--panels shapes,bends,growth,portrait --times 0,1,2,3) ;;
  shoot-*) what=(--panels shapes,curvature --times 0,0.5,1,2,3) ;;
  vine-corners) what=(--panels shapes --times 3,5,7,9) ;;
  esac
  case $name in
  stability-dry | stability-viscous) # with a run below: its smallest |x2| beside t_cr
    build/tendril -quiet -friction_mu "$([ "$name" = stability-dry ] && echo 1 || echo 0)" -ts_max_time 2 -output results/run.h5
    .venv/bin/python -m tendril stability "results/$name.h5" --run results/run.h5 --output "results/gallery-$name"
    ;;
  *) .venv/bin/python -m tendril plot "${files[@]}" "${what[@]}" --output "results/gallery-$name" ;;
  esac
  cp "results/gallery-$name.png" "options/pictures/$name.png"
done
