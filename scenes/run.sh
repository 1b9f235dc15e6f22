#!/usr/bin/env bash
# From nothing to a picture: installs what is missing, builds, runs a scene, draws it.
#   bash scenes/run.sh [SCENE] [arguments of `perimpm run`]      a file, or the name of one in scenes/; default: bunnies
# JOBS: parallel compile jobs. PERIMPM_PACKAGES_READY=1: trust that the packages are there (systems without apt).
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
source "$root/.ci/setup.sh"

scene="$root/scenes/bunnies.toml"
case "${1:-}" in
    "" | -*) ;;
    *) scene=$1; shift ;;
esac
[ -f "$scene" ] || [ ! -f "$root/scenes/$scene.toml" ] || scene="$root/scenes/$scene.toml"
[ -f "$scene" ] || { say "no scene file '$scene'; there are: $(cd "$root" && echo scenes/*.toml)" >&2; exit 2; }
output="$root/out/$(basename "${scene%.*}")"
arguments=("$@")
for ((i = 0; i < $#; ++i)); do
    case "${arguments[i]}" in
        -o | --output) output=${arguments[i + 1]:-$output} ;;
        --output=*) output=${arguments[i]#*=} ;;
    esac
done

install_perimpm render ""
say "running $scene"
"$venv/bin/perimpm" run "$scene" -o "$output" "$@"
say "drawing"
"$venv/bin/perimpm" render "$output"
say "frames:     $output/frame.*.h5, $output/run.xdmf (ParaView)"
say "picture:    $output/pictures/poster.png"
say "animation:  $output/pictures/animation.mp4"
