#!/usr/bin/env bash
# Installs what is missing on Debian 12, through apt: dependencies.sh build|tests
#   build  compiler, CMake and the libraries
#   tests  those, and the programs that tests run: other compilers, an emulator, another importer, a browser, Node.js
# Needs root or sudo only if something is missing.
set -euo pipefail

build_packages=(
  cmake g++ ninja-build pkg-config
  libcli11-dev libdraco-dev libfmt-dev libglm-dev libgtest-dev libmeshoptimizer-dev libstb-dev libtbb-dev libtinygltf-dev
  libxxhash-dev nlohmann-json3-dev
  libeigen3-dev libembree-dev
)
test_packages=(assimp-utils chromium clang g++-aarch64-linux-gnu python3 qemu-user)

packages=("${build_packages[@]}")
case "${1:-build}" in
  build) ;;
  tests) packages+=("${test_packages[@]}") ;;
  *) echo "usage: dependencies.sh build|tests" >&2; exit 1 ;;
esac

missing=()
for package in "${packages[@]}"; do
  [[ $(dpkg-query --show --showformat='${db:Status-Status}' "$package" 2>/dev/null) == installed ]] || missing+=("$package")
done
# Node.js may come from elsewhere than Debian; then Debian's packages would be in its way.
if [[ ${1:-build} == tests ]]; then
  command -v node >/dev/null || missing+=(nodejs)
  command -v npm >/dev/null || missing+=(npm)
fi
((${#missing[@]})) || exit 0

echo "Installing: ${missing[*]}"
as_root=()
if ((EUID != 0)); then
  command -v sudo >/dev/null || { echo "$0: needs root or sudo to install: ${missing[*]}" >&2; exit 1; }
  as_root=(sudo)
fi
export DEBIAN_FRONTEND=noninteractive
"${as_root[@]}" apt-get update -q
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends "${missing[@]}" </dev/null
