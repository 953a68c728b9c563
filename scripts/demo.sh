#!/usr/bin/env bash
# Installs what is missing, builds the release, packs and unpacks a sample and tells sizes and errors.
# demo.sh [ASSET]: another asset than samples/slug.glb.
set -euo pipefail
asset=$(realpath "${1:-$(dirname "$0")/../samples/slug.glb}")
cd "$(dirname "$0")/.."

scripts/dependencies.sh build
cmake --preset release -DGLTF_TSC_BUILD_TESTS=OFF
cmake --build --preset release --target gltf-tsc

out=build/demo
mkdir -p "$out"
name=$(basename "${asset%.*}")
tool=build/release/src/cli/gltf-tsc
echo
echo "== pack"
"$tool" pack "$asset" -o "$out/$name.packed.glb" --force --verbose
echo "== inspect"
"$tool" inspect "$out/$name.packed.glb"
echo "== unpack"
"$tool" unpack "$out/$name.packed.glb" -o "$out/$name.unpacked.glb" --force
if "$tool" compare --help >/dev/null 2>&1; then
  echo "== compare the original with the unpacked one"
  "$tool" compare "$asset" "$out/$name.unpacked.glb"
fi
ls -l "$asset" "$out/$name.packed.glb" "$out/$name.unpacked.glb" | awk '{print $5, "bytes", $NF}'
