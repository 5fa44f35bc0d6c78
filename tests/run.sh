#!/usr/bin/env bash
# Installs what is missing, builds, and runs every test. ctest's closing line comes last.
#
#   tests/run.sh            everything
#   tests/run.sh --quick    without the sanitizer build
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cd "$root"
quick=${1:-}

tools/dev/install.sh

echo "format: clang-format on every source"
git ls-files '*.hpp' '*.cpp' | xargs clang-format-14 --dry-run -Werror

if [ "$quick" != "--quick" ]; then
  tools/dev/build.sh asan
  ASAN_OPTIONS=detect_leaks=1:allocator_may_return_null=1 UBSAN_OPTIONS=print_stacktrace=1 \
    ctest --test-dir build/asan --output-on-failure -j2
fi

tools/dev/build.sh release
ctest --test-dir build/release --output-on-failure -j2
