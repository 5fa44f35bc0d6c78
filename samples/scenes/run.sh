#!/usr/bin/env bash
# Makes a survey of each scene, proves it, and locates what is in it. Usage: run.sh [FOLDER] (default: results/scenes)
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
cairn="${CAIRN:-$root/build/release/bin/cairn}"
out="${1:-$root/results/scenes}"
[ -x "$cairn" ] || { echo "build cairn first: tools/dev/build.sh release --target cairn" >&2; exit 1; }
mkdir -p "$out"
for scene in tiny experiment_1 experiment_2 experiment_2_rtk experiment_2_gps boulder_field; do
  echo "== $scene"
  "$cairn" simulate "$root/samples/scenes/$scene.json" --seed 1 -o "$out/$scene" --overwrite
  "$cairn" check "$out/$scene" --quiet
  "$cairn" locate "$out/$scene" -o "$out/${scene}_located" --overwrite
done
echo "Surveys and results in $out"
