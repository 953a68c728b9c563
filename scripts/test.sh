#!/usr/bin/env bash
# Installs what is missing, builds and runs the tests: test.sh [PRESET], by default `release`: all tests.
set -euo pipefail
cd "$(dirname "$0")/.."
preset=${1:-release}

scripts/dependencies.sh tests
cmake --preset "$preset"
cmake --build --preset "$preset"
# The Khronos validator and three.js; without a network their tests skip, and say so.
if [[ $preset == release ]]; then
  for packages in validator render; do
    npm install --prefix "build/$preset/$packages" --no-audit --no-fund --loglevel=error </dev/null ||
      echo "npm could not install what build/$preset/$packages/package.json names; its tests will be skipped" >&2
  done
fi
ctest --preset "$preset" -j "$(nproc)"
