#!/usr/bin/env bash
# Installs tendril into a place of its own, builds a user's program against it by pkg-config and by
# CMake, runs it, and takes tendril away again.   test.sh BUILD_DIRECTORY
set -euo pipefail
build=$1
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
expected='tip (2.9909'
cmake --install "$build" --prefix "$place/usr" >"$place/log"
for file in bin/tendril share/man/man1/tendril.1 share/tendril/options/feed.opts; do
  [ -f "$place/usr/$file" ] || { echo "not installed: $file" && exit 1; }
done
"$place/usr/bin/tendril" -version
libdir=$(dirname "$(find "$place/usr" -name libtendril.so)")
headers=$(find "$place/usr/include" -type f)
[ "$headers" = "$place/usr/include/tendril.h" ] || { echo "headers that are installed: $headers" && exit 1; }
# (xerbla_ stands for LAPACK's own, which ends the program on a matrix that it refuses, with exit 0)
seen=$(nm -D --defined-only "$libdir/libtendril.so" | awk '$2 == "T" { print $3 }' | grep -vE '^(Tendril|xerbla_$)' || true)
[ -z "$seen" ] || { echo "seen from outside, and no part of the interface: $seen" && exit 1; }

export PKG_CONFIG_PATH=$libdir/pkgconfig${PKG_CONFIG_PATH:+:$PKG_CONFIG_PATH} LD_LIBRARY_PATH=$libdir:${LD_LIBRARY_PATH:-}
for own in "${PETSC_DIR:-}" "${SLEPC_DIR:-}"; do # not the system's: as CMakeLists.txt finds them
  [ "$own" ] || continue
  PKG_CONFIG_PATH=$own/${PETSC_ARCH:-}/lib/pkgconfig:$own/lib/pkgconfig:$PKG_CONFIG_PATH
  LD_LIBRARY_PATH=$own/${PETSC_ARCH:-}/lib:$own/lib:$LD_LIBRARY_PATH
done
read -r -a flags <<<"$(pkg-config --cflags --libs tendril)"
cc "$here/grow_rod.c" -o "$place/by-pkg-config" "${flags[@]}" -Wl,--no-as-needed
"$place/by-pkg-config" | tee "$place/out"
grep -qF "$expected" "$place/out"

cmake -S "$here" -B "$place/cmake" -DCMAKE_PREFIX_PATH="$place/usr" >"$place/log"
cmake --build "$place/cmake" >"$place/log" || { cat "$place/log" && exit 1; }
"$place/cmake/grow_rod" | grep -F "$expected"
(cd "$place" && TENDRIL=$place/usr/bin/tendril PYTHONPATH=$here/../../scripts "${PYTHON:-python3}" - "$libdir" <<'END'
import sys, tendril.simulation as simulation
simulation.CHECKOUT = simulation.Path("/nowhere")  # what is installed is to be found beside the program
sim = simulation.Simulation(growth_initial_length=2, shape_amplitude=0.1, ts_max_time=1)
assert simulation.library()._name.startswith(sys.argv[1]), simulation.library()._name
assert sim.advance(0.5) and sim.x.shape == (501, 2)
END
)

cmake --build "$build" --target uninstall >"$place/log"
left=$(find "$place/usr" ! -type d)
[ -z "$left" ] || { echo "left behind: $left" && exit 1; }
echo "installed, used by pkg-config and by CMake, taken away"
