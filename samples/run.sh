#!/usr/bin/env bash
# Installs what is missing, builds cairn, runs the main job on a real survey, and says where to look.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
"$root/tools/dev/install.sh"
"$root/tools/dev/build.sh" release --target cairn
"$root/samples/brighton_beach/run.sh"
