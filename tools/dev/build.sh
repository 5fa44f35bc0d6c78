#!/usr/bin/env bash
# Configures and builds one preset (default: release) into build/<preset>.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
preset=${1:-release}
shift || true
cd "$root"
echo "build: preset $preset in build/$preset"
cmake --preset "$preset" >"/tmp/cairn-configure-$$.log" 2>&1 || { cat "/tmp/cairn-configure-$$.log"; exit 1; }
rm -f "/tmp/cairn-configure-$$.log"
cmake --build --preset "$preset" "$@"
