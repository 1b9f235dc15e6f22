#!/usr/bin/env bash
# Installs what is missing, builds, and runs every test: Catch2 through CTest, then pytest. Fails when any part fails.
#   bash tests/run.sh [arguments of pytest]
# JOBS: parallel jobs. PERIMPM_PACKAGES_READY=1: trust that the packages are there (systems without apt).
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
source "$root/.ci/setup.sh"

install_perimpm render,test tests
failed=()
say "C++ tests"
ctest --test-dir "$build" --output-on-failure -j "$jobs" || failed+=("CTest")
say "Python tests"
(cd "$root" && "$venv/bin/python" -m pytest "$@") || failed+=("pytest")
[ ${#failed[@]} -eq 0 ] || { say "failed: ${failed[*]}"; exit 1; }
say "all tests passed"
