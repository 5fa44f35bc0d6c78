#!/usr/bin/env bash
# The main job on the Brighton Beach survey: import, check, and the whole post-flight recipe.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
root=$(cd "$here/../.." && pwd)
cairn=${CAIRN:-$root/build/release/bin/cairn}

echo "import: poses by COLMAP, 1600-pixel photographs, recorded detections, cloud with its similarity"
"$cairn" import colmap "$here/colmap_enu" --images "$here/images_1600" \
  --origin 46.8426,-91.9940,158.0 --height-type ellipsoidal --scale-images 0.4 \
  --detections "$here/detections.csv" --cloud "$here/model.las" --similarity "$here/enu_frame.json" \
  --name "Brighton Beach" -o "$here/survey" --overwrite

echo "check: is the survey sound?"
"$cairn" check "$here/survey"

echo "run: the post-flight job"
"$cairn" run "$root/pipelines/post_flight.json" "$here/survey" -o "$here/out" --overwrite

echo
echo "Look at samples/brighton_beach/out/report/index.html"
