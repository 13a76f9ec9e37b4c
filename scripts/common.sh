# Shared by the scripts beside it (sourced): works from the root of the repository, sets what MPI
# needs, and has `logged` and `build`. Files that a user names count from where the user is: scripts
# that take any go back there, `cd "$started"`, and name the project's own by "$root".
# shellcheck shell=bash disable=SC2034
# -h behind any of them: what stands at its head
case ${1:-} in
-h | --help)
  awk 'NR > 1 && !/^#/ { exit } NR > 1 && !/shellcheck/ { sub(/^# ?/, ""); print }' "$0"
  exit
  ;;
esac
started=$PWD
cd "$(dirname "${BASH_SOURCE[0]}")/.." || exit
root=$PWD
# Open MPI refuses root without these; one thread per rank, for BLAS.
export PYTHONPATH=$PWD/scripts${PYTHONPATH:+:$PYTHONPATH} # the package tendril
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMP_NUM_THREADS=1

fail() {
  echo "$(basename "$0" .sh): $1" >&2
  exit 1
}

cores() {
  env -u OMP_NUM_THREADS nproc # which takes that for a limit
}

# logged LOG WHAT COMMAND...: runs the command with its output added to the log; shows the log's end
# if it fails
logged() {
  local log=$1 what=$2
  shift 2
  if ! "$@" >>"$log" 2>&1 </dev/null; then
    tail -n 25 "$log" >&2
    fail "$what failed; the whole log is in $log"
  fi
}

# build DIRECTORY TARGET [CMAKE OPTIONS]: configures and builds
build() {
  local directory=$1 target=$2
  shift 2
  mkdir -p "$directory"
  # a checkout that was copied or moved: CMake's cache is of the other place
  if [ -f "$directory/CMakeCache.txt" ] &&
    ! grep -qx "CMAKE_HOME_DIRECTORY:INTERNAL=$PWD" "$directory/CMakeCache.txt"; then
    rm -rf "$directory"
    mkdir -p "$directory"
  fi
  : >"$directory/build.log"
  logged "$directory/build.log" "cmake" cmake -S . -B "$directory" "$@"
  logged "$directory/build.log" "the build" \
    cmake --build "$directory" --target "$target" --parallel "${CMAKE_BUILD_PARALLEL_LEVEL:-$(cores)}"
}
