#!/usr/bin/env bash
# Puts on this machine what tendril needs, where it is missing: Debian's packages (as root or with
# sudo) and a virtual environment for the Python package, .venv. Does nothing when all is there.
#   scripts/setup.sh [tests]       tests: also what only these need
set -euo pipefail
# shellcheck source-path=SCRIPTDIR
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

packages=(gcc make cmake pkg-config libopenmpi-dev openmpi-bin libhdf5-openmpi-dev liblapack-dev
          python3-venv)
if [ "${1:-}" = tests ]; then packages+=(libcmocka-dev clang-format valgrind); fi
if [ -z "${PETSC_DIR:-}" ]; then packages+=(petsc-dev); fi
if [ -z "${SLEPC_DIR:-}" ]; then packages+=(slepc-dev); fi
log=build/setup.log

missing_packages() {
  local present package
  # one call for all: dpkg-query leaves out what it does not know and then exits with 1
  present=$(dpkg-query -W -f '${db:Status-Status} ${Package}\n' "${packages[@]}" 2>/dev/null) || true
  for package in "${packages[@]}"; do
    grep -qx "installed $package" <<<"$present" || echo "$package"
  done
}

install_packages() {
  local command missing root=()
  if ! command -v apt-get >/dev/null; then
    for command in gcc make cmake pkg-config mpicc mpiexec python3; do
      command -v "$command" >/dev/null ||
        fail "no $command and no apt-get here: install what Debian calls ${packages[*]}"
    done
    return
  fi
  mapfile -t missing < <(missing_packages)
  if [ ${#missing[@]} = 0 ]; then return; fi
  if [ "$(id -u)" != 0 ]; then
    command -v sudo >/dev/null || fail "no sudo here; as root, run: apt-get install ${missing[*]}"
    if ! sudo -n true 2>/dev/null; then
      [ -t 0 ] || fail "sudo wants a password; run: sudo apt-get install ${missing[*]}"
      sudo -v || fail "sudo refused; as root, run: apt-get install ${missing[*]}"
    fi
    root=(sudo)
  fi
  root+=(env DEBIAN_FRONTEND=noninteractive)
  echo "setup: installing ${missing[*]}"
  # Lists that cannot be refreshed may still serve; the installation itself decides.
  "${root[@]}" apt-get update >>"$log" 2>&1 </dev/null || true
  logged "$log" "apt-get install ${missing[*]}" \
    "${root[@]}" apt-get install -y --no-install-recommends "${missing[@]}"
}

# A browser without a screen, for the tests of pages; without one these say that they are left out.
install_browser() {
  local one root=()
  for one in chromium chromium-browser google-chrome chromium-headless-shell; do
    if command -v "$one" >/dev/null; then return; fi
  done
  if [ "$(id -u)" != 0 ]; then root=(sudo -n); fi
  echo "setup: installing chromium-headless-shell, for the tests of pages"
  "${root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends chromium-headless-shell >>"$log" 2>&1 </dev/null ||
    echo "setup: it cannot be had: pages are NOT TRIED in a browser"
}

# What .venv was made for: an older one is brought up to date, and keeps what else is in it.
wanted() {
  cat scripts/requirements.txt scripts/pyproject.toml
}

make_venv() {
  local stamp=.venv/made_for candidate python=
  if .venv/bin/python -c 'import pip' 2>/dev/null; then
    if cmp -s <(wanted) "$stamp"; then return; fi
    echo "setup: bringing .venv up to date"
  else
    for candidate in /usr/bin/python3 python3; do
      if "$candidate" -c 'import ensurepip, venv' 2>/dev/null; then
        python=$candidate
        break
      fi
    done
    [ "$python" ] || fail "no python3 with the modules venv and ensurepip; install python3-venv"
    echo "setup: making .venv with the Python package and what it needs"
    logged "$log" "making .venv" "$python" -m venv --clear .venv
  fi
  logged "$log" "installing the Python package (scripts/pyproject.toml) into .venv" \
    .venv/bin/python -m pip install --disable-pip-version-check -q -e scripts
  wanted >"$stamp"
}

mkdir -p build
: >"$log"
install_packages
if [ "${1:-}" = tests ]; then install_browser; fi
make_venv
