#!/usr/bin/env bash
# Runs tendril over any grid of options, one result file a point, in parallel: in one job (-task
# sweep) if each point grows a rod or finds a critical length, else a process a point.
#   scripts/sweep.sh DIRECTORY [-j JOBS AT A TIME] [FIXED OPTIONS ...] -- NAME VALUES [NAME VALUES ...]
#   scripts/sweep.sh results/map -task critical -growth_type gaussian -- \
#     friction_mu 0:1:20 growth_width log:0.05:5:20
# VALUES is a comma list, or low:high:count (even), or log:low:high:count; with a unit 1cm:5cm:9. A slash
# of a value, 0.3N/m, is _ in the name of its file.
# A point that has a finished result file is passed over, so a sweep that was stopped goes on. Failed
# points are listed at the end and in DIRECTORY/failed.*; their messages are in DIRECTORY/*.log.
# As a Slurm job array, the same command: each task takes its share of the points.
#   sbatch --array=0-99 scripts/sweep.sh DIRECTORY ... -- ...
# Files and directories count from where one is.
# TENDRIL names the executable (build/tendril of the project), MPIEXEC what starts it on several cores (mpiexec).
set -euo pipefail
here=$(dirname "${BASH_SOURCE[0]}")
# In a job array the script is a copy elsewhere; it is started from the repository.
if [ ! -f "$here/common.sh" ]; then here=${SLURM_SUBMIT_DIR:-$PWD}/scripts; fi
# shellcheck source-path=SCRIPTDIR
source "$here/common.sh"

usage() {
  echo "sweep: $1; see the head of scripts/sweep.sh" >&2
  exit 2
}

# values SPEC: one value a line; bounds may carry a unit, 1cm:5cm:9
values() {
  local number='([-+]?[0-9.]+([eE][-+]?[0-9]+)?)([^:]*)' even='a + (b - a) * x'
  case $1 in
  log:*:*:*) even='a * exp(log(b / a) * x)' ;;
  *:*:*) ;;
  *) tr ',' '\n' <<<"$1" && return ;;
  esac
  [[ ${1#log:} =~ ^$number:$number:([0-9]+)$ ]] || return 0
  [ "${BASH_REMATCH[3]}" = "${BASH_REMATCH[6]}" ] || return 0
  awk -v a="${BASH_REMATCH[1]}" -v b="${BASH_REMATCH[4]}" -v n="${BASH_REMATCH[7]}" \
    -v unit="${BASH_REMATCH[6]}" "BEGIN { for (i = 0; i < n; i++) {
      x = n > 1 ? i / (n - 1) : 0; printf \"%.10g%s\\n\", $even, unit } }"
}

# task_of OPTIONS ...: what each point does: as the last -task says, here or in an options file
task_of() {
  local word before='' task=grow
  for word in "$@"; do
    case $before in
    -task) task=$word ;;
    -options_file) task=$(awk -v t="$task" '$1 == "-task" { t = $2 } END { print t }' "$word") ;;
    esac
    before=$word
  done
  echo "$task"
}

# together DIRECTORY TASK JOBS POINTS ...: all points in one job
together() {
  local directory=$1 task=$2 jobs=$3 point word before='' rest=() launch=() pairs=() names=() values=()
  local table=$directory/running/$SWEEP_ID
  shift 3
  for word in "${fixed[@]}"; do # the options of a point, but for -task
    if [ "$word" != -task ] && [ "$before" != -task ]; then rest+=("$word"); fi
    before=$word
  done
  rm -f "$table".* # of an earlier sweep; what it finished has its place
  for point in "$@"; do
    IFS=$'\t' read -r -a pairs <<<"${point//__/$'\t'}"
    names=("${pairs[@]%%=*}") values=("${pairs[@]#*=}")
    values=("${values[@]//\"/\"\"}")
    [ -f "$table.csv" ] || (IFS=, && echo "${names[*]}") >"$table.csv"
    (IFS=, && echo "${values[*]/#/\"}" | sed 's/,"/","/g; s/$/"/') >>"$table.csv"
  done
  if [ "$jobs" -gt 1 ]; then launch=("${MPIEXEC:-mpiexec}" -n "$jobs"); fi
  "${launch[@]}" "$TENDRIL" "${rest[@]}" -task sweep -sweep_file "$table.csv" -sweep_task "$task" \
    -sweep_directory "$directory" -output "$table.h5" >"$table.log" 2>&1 </dev/null ||
    fail "$(grep -m 1 "^tendril: " "$table.log" || tail -n 1 "$table.log")"
  for point in "$@"; do
    [ -f "$directory/${point//\//_}.h5" ] || echo "$point" >>"$directory/failed.$SWEEP_ID"
  done
  rm -f "$table".*
}

# one DIRECTORY POINT: a single run; its files get their place only when the run is whole
one() {
  local directory=$1 point=${2//\//_} fixed=() pairs=() options=()
  mapfile -t fixed <"$directory/options"
  IFS=$'\t' read -r -a pairs <<<"${2//__/$'\t'}"
  for pair in "${pairs[@]}"; do options+=("-${pair%%=*}" "${pair#*=}"); done
  for _ in 1 2 3; do
    if "$TENDRIL" "${fixed[@]}" "${options[@]}" -output "$directory/running/$point.h5" \
      >"$directory/$point.log" 2>&1 </dev/null; then
      if [ -f "$directory/running/$point.xmf" ]; then
        mv "$directory/running/$point.xmf" "$directory/$point.xmf"
      fi
      mv "$directory/running/$point.h5" "$directory/$point.h5"
      return
    fi
    # now and then MPI itself does not start on a busy machine, which says nothing about the run
    grep -q "before MPI_INIT" "$directory/$point.log" || break
  done
  rm -f "$directory/running/$point".*
  return 1
}

cd "$started"
export TENDRIL=${TENDRIL:-$root/build/tendril}
# Open MPI then starts a single process without a daemon of its own; several where they may run, as
# many as are asked for (by one name up to version 4, by another from 5 on).
export OMPI_MCA_ess_singleton_isolated=1 OMPI_MCA_rmaps_base_oversubscribe=1 \
  OMPI_MCA_hwloc_base_binding_policy=none PRTE_MCA_hwloc_default_binding_policy=none \
  PRTE_MCA_rmaps_default_mapping_policy=:oversubscribe
if [ "${1:-}" = --one ]; then
  shift
  if ! one "$@"; then echo "$2" >>"$1/failed.$SWEEP_ID"; fi
  exit 0
fi

[ $# -gt 0 ] || usage "give a directory"
directory=$1
shift
jobs=
if [ "${1:-}" = -j ]; then
  jobs=${2:-}
  [[ $jobs =~ ^[1-9][0-9]{0,3}$ ]] || usage "-j $jobs: give the number of runs at a time, from 1"
  shift 2
fi
fixed=()
while [ $# -gt 0 ] && [ "$1" != -- ]; do fixed+=("$1") && shift; done
[ "${1:-}" = -- ] || usage "give -- and the options to vary"
shift
before=
for word in "${fixed[@]}"; do
  if [ "$before" = -options_file ] && [ ! -r "$word" ]; then fail "no options file $word"; fi
  before=$word
done
if [ $# = 0 ] || [ $(($# % 2)) = 1 ]; then usage "give NAME VALUES pairs after --"; fi
[ -x "$TENDRIL" ] || fail "no executable $TENDRIL; run scripts/setup.sh and build, or set TENDRIL"

points=("")
while [ $# -gt 0 ]; do
  longer=()
  [[ $1 =~ ^-?[a-z][a-z0-9_]*$ ]] || usage "$1: is no name of an option"
  [[ ! $2 =~ :[0-9]{7,}$ ]] || usage "$1 $2: too many values; give at most 999999"
  mapfile -t each < <(values "$2")
  [ ${#each[@]} -gt 0 ] || usage "$1 $2: no values; give a comma list, LOW:HIGH:COUNT or log:LOW:HIGH:COUNT, both in one unit"
  for point in "${points[@]}"; do
    for value in "${each[@]}"; do longer+=("${point:+${point}__}${1#-}=$value"); done
  done
  points=("${longer[@]}")
  shift 2
done

# Points are passed over by name, so those of other options, or of an options file that has been
# edited since, must not be taken for these.
what() {
  local word before=
  for word in "${fixed[@]}"; do
    if [ "$before" = -options_file ]; then cat "$word" 2>/dev/null || fail "no options file $word"; fi
    before=$word
  done
}
# stored: if anything is that could be taken for a result of other options
stored() {
  compgen -G "$directory/*.h5" >/dev/null || compgen -G "$directory/running/*.h5" >/dev/null
}
# keep FILE TEXT: notes it there, at one blow (other tasks may look); fails if something else stands
# there, and results of it
keep() {
  printf '%s' "$2" >"$1.$$"
  if [ -f "$1" ] && { [ "$SWEEP_ID" != all ] || stored; } && ! cmp -s "$1.$$" "$1"; then
    rm "$1.$$"
    fail "$directory holds a sweep with other options, or of an options file that was edited since; give another directory"
  fi
  mv "$1.$$" "$1"
}
if ! mkdir -p "$directory/running" 2>/dev/null || [ ! -w "$directory" ] || [ ! -w "$directory/running" ]; then
  fail "$directory: nothing can be written there; give a directory of a disk and a place where you may write"
fi
# One sweep at a time (and task of a job array): a second would take away what the first is writing.
export SWEEP_ID=${SLURM_ARRAY_TASK_ID:-all} # each task of a job array keeps its own account
if command -v flock >/dev/null; then
  exec 9>>"$directory/running/lock.$SWEEP_ID"
  flock -n 9 || fail "$directory: another sweep is at work there; wait for its end, or give another directory"
fi
lines=
if [ ${#fixed[@]} -gt 0 ]; then printf -v lines '%s\n' "${fixed[@]}"; fi
keep "$directory/options" "$lines"
keep "$directory/scene" "$(what)"

task=${SLURM_ARRAY_TASK_ID:-0}
task=$((task - ${SLURM_ARRAY_TASK_MIN:-0}))
tasks=${SLURM_ARRAY_TASK_COUNT:-1}
mine=()
for i in "${!points[@]}"; do
  if [ $((i % tasks)) = "$task" ] && [ ! -f "$directory/${points[i]//\//_}.h5" ]; then
    mine+=("${points[i]}")
  fi
done
job=$(task_of "${fixed[@]}")
if [[ " ${fixed[*]} " == *" -restart "* ]]; then job=restart; fi
case $job in
grow | critical) jobs=${jobs:-$(cores)} ;;
*) jobs=${jobs:-$((2 * $(cores)))} ;; # short processes mostly wait for MPI to start and end
esac
echo "sweep: ${#points[@]} points, ${#mine[@]} to run here, $jobs at a time, in $directory"
failed=$directory/failed.$SWEEP_ID
rm -f "$failed"
if [ ${#mine[@]} -gt 0 ] && [[ $job =~ ^(grow|critical)$ ]]; then
  together "$directory" "$job" $((jobs < ${#mine[@]} ? jobs : ${#mine[@]})) "${mine[@]}"
elif [ ${#mine[@]} -gt 0 ]; then
  printf '%s\0' "${mine[@]}" | xargs -0 -P "$jobs" -I {} "$root/scripts/sweep.sh" --one "$directory" {}
fi
if [ -s "$failed" ]; then
  sort -o "$failed" "$failed"
  echo "sweep: $(wc -l <"$failed") points failed ($failed):" >&2
  while read -r point; do
    echo "  $point: $(tail -n 1 "$directory/${point//\//_}.log")" >&2
  done <"$failed"
  exit 1
fi
