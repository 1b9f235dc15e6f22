# Shared by scenes/run.sh and tests/run.sh, which source it: system packages, .venv, build and install.
# Needs: `root`, the repository's folder. Gives: install_perimpm EXTRAS TESTS, and the variables venv and build.

venv="$root/.venv"
jobs="${JOBS:-$(nproc)}"

packages=(
    g++ cmake ninja-build python3-dev python3-venv
    libeigen3-dev libtbb-dev libhdf5-dev libassimp-dev libopenvdb-dev libboost-iostreams-dev
    nlohmann-json3-dev libtomlplusplus-dev libfmt-dev
    libegl1 libgl1-mesa-dri    # pictures without a display
)
test_packages=(catch2)

say() { printf '== %s\n' "$*"; }

is_installed() { [ "$(dpkg-query -W -f='${db:Status-Status}' "$1" 2>/dev/null)" = installed ]; }

# Installs what is missing on Debian and Ubuntu; elsewhere it only names the packages.
install_packages() {
    local missing=() package
    if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
        [ "${PERIMPM_PACKAGES_READY:-0}" = 1 ] && return
        say "this system is not Debian or Ubuntu; install what corresponds to these Debian packages:"
        printf '   %s\n' "$*"
        say "then run again with PERIMPM_PACKAGES_READY=1"
        exit 1
    fi
    for package in "$@"; do is_installed "$package" || missing+=("$package"); done
    [ ${#missing[@]} -eq 0 ] && return
    if [ "$(id -u)" -ne 0 ]; then
        say "these packages are missing; install them as root and run again:"
        printf '   apt-get install -y --no-install-recommends %s\n' "${missing[*]}"
        exit 1
    fi
    say "installing ${#missing[@]} system packages: ${missing[*]}"
    export DEBIAN_FRONTEND=noninteractive
    logged packages.log apt-get update
    logged packages.log apt-get install -y --no-install-recommends "${missing[@]}"
}

# Runs a command quietly. Its log is of this attempt only and ends with how it went; what fails shows the last lines.
logged() {
    local log="$root/build/$1" status=0
    shift
    mkdir -p "$root/build"
    say "$(date '+%F %T'): $*" >"$log"
    trap 'unfinished "$log" "stopped from outside; run again"' HUP INT TERM
    "$@" >>"$log" 2>&1 || status=$?
    trap - HUP INT TERM
    if [ "$status" -gt 128 ]; then
        unfinished "$log" "killed from outside by signal $((status - 128)); run again"
    elif [ "$status" -ne 0 ] && grep -qiE 'killed signal|died with <signals|exit code: -[0-9]|interrupted by user' "$log"; then
        unfinished "$log" "a process in it was killed from outside; run again, with JOBS=1 if memory ran out"
    elif [ "$status" -ne 0 ]; then
        unfinished "$log" "exit code $status"
    fi
    say "finished" >>"$log"
}

# unfinished LOG WHY: ends the script.
unfinished() {
    trap - HUP INT TERM
    tail -n 40 "$1" >&2
    say "did not finish: $2" >>"$1"
    say "did not finish: $2   (above: the end of $1, which is of this attempt only)" >&2
    exit 1
}

# One line that changes when anything that goes into the package changes.
fingerprint() {
    (
        cd "$root"
        printf '%s\n' "$@" "$("$venv/bin/python" -VV)" "${2:+${PERIMPM_WARNINGS_ARE_ERRORS:-OFF}}"   # of the C++ tests' builds
        find CMakeLists.txt pyproject.toml core plugins bindings ${2:+tests} -type f ! -name '*.pyc' -print0 |
            sort -z | xargs -0 sha256sum
    ) | sha256sum
}

# install_perimpm EXTRAS TESTS: EXTRAS as in pip's brackets; TESTS is "tests" to build the C++ tests, too, or empty.
install_perimpm() {
    local extras=$1 tests=$2 stamp="$venv/perimpm.stamp${2:+.tests}" print
    install_packages "${packages[@]}" ${tests:+"${test_packages[@]}"}
    [ -x "$venv/bin/python" ] || { say "making $venv"; python3 -m venv "$venv"; }
    build="$root/build/$("$venv/bin/python" "$root/.ci/build_tag.py")"
    print=$(fingerprint "$extras" "$tests")
    [ -e "$stamp" ] && [ "$(cat "$stamp")" = "$print" ] && [ -d "$build" ] && return
    say "building with $jobs jobs (some minutes the first time; log in build/install.log)"
    rm -f "$venv"/perimpm.stamp* "$root"/build/{pip,install}.log   # no log of an earlier attempt stays
    logged pip.log "$venv/bin/pip" install --disable-pip-version-check "scikit-build-core>=0.10" "pybind11>=2.12"
    # Without isolation the paths of the build tools stay the same, so that only what changed is compiled again.
    CMAKE_BUILD_PARALLEL_LEVEL="$jobs" CMAKE_GENERATOR=Ninja logged install.log \
        "$venv/bin/pip" install --disable-pip-version-check -v --no-build-isolation \
        --config-settings=cmake.define.PERIMPM_BUILD_TESTS="$([ -n "$tests" ] && echo ON || echo OFF)" \
        --config-settings=cmake.define.CMAKE_COMPILE_WARNING_AS_ERROR="${PERIMPM_WARNINGS_ARE_ERRORS:-OFF}" "$root[$extras]"
    printf '%s\n' "$print" >"$stamp"
    if [ -n "$tests" ]; then fingerprint render "" >"$venv/perimpm.stamp"; fi   # what scenes/run.sh needs is there, too
}
