#!/usr/bin/env bash
# From a cloud to fragility: Double Rock on a made pedestal is scanned, cut out, closed and tipped, and what comes out is
# held against the rock's published mass properties. Usage: run.sh [FOLDER] (default: results/double_rock)
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
root=$(cd "$here/../.." && pwd)
cairn="${CAIRN:-$root/build/release/bin/cairn}"
out="${1:-$root/results/double_rock}"
[ -x "$cairn" ] || { echo "build cairn first: tools/dev/build.sh release --target cairn" >&2; exit 1; }
mkdir -p "$out"

echo "simulate: three rings of photographs; a cloud of 1 cm spacing with 5 mm noise"
"$cairn" simulate "$here/scene.json" --seed 1 -o "$out/survey" --overwrite

echo "segment: the target, a cylinder round the rock, says where it is"
"$cairn" segment "$out/survey/cloud.las" --targets "$here/targets.json" -o "$out/labelled.las" --overwrite

echo "surface: a closed mesh through the contact line"
"$cairn" surface "$out/labelled.las" -o "$out/rocks" --overwrite

echo "fragility: 1000 draws at the published density"
"$cairn" fragility "$out/rocks" --density 2600 --draws 1000 -o "$out/fragility" --overwrite

echo "evaluate: against the mesh that was scanned"
"$cairn" evaluate segmentation "$out/labelled.las" --truth "$out/survey/cloud.las" --rocks "$out/fragility" \
  -o "$out/scores.json" --overwrite

echo "Results in $out; the polar plot of tipping is $out/fragility/*_tipping.svg"
