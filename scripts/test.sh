#!/usr/bin/env bash
# Installs what is missing, builds and runs the tests: test.sh [PRESET], by default `release`: all tests.
set -euo pipefail
cd "$(dirname "$0")/.."
preset=${1:-release}

scripts/dependencies.sh tests
cmake --preset "$preset"
cmake --build --preset "$preset"
# The Khronos validator; without a network its tests skip, and say so.
if [[ $preset == release ]]; then
  npm install --prefix "build/$preset/validator" --no-audit --no-fund --loglevel=error </dev/null ||
    echo "npm could not install the validator; its tests will be skipped" >&2
fi
ctest --preset "$preset" -j "$(nproc)"
