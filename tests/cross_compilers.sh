#!/usr/bin/env bash
# Proves that the codec writes the same bytes and decodes to the same bits whatever compiler, optimisation and processor:
#   cross_compilers.sh WORK_FOLDER [--update]
# builds src/codec and codec_hashes.cpp with each compiler at hand, and compares what they print with hashes.txt.
# --update writes hashes.txt anew: for changes of the format, on purpose. Returns 77 if there is only one compiler.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
work=${1:?usage: cross_compilers.sh WORK_FOLDER [--update]}
expected=$here/hashes.txt
mkdir -p "$work"
work=$(cd "$work" && pwd)

# A name, the program that runs the result (or nothing), the compiler with its flags.
tools=(
  "gcc-O0||g++ -O0"
  "gcc-O3-native||g++ -O3 -march=native"
  "clang-O2||clang++ -O2"
  "aarch64-O2|qemu-aarch64|aarch64-linux-gnu-g++ -O2 -static"
)

build_and_run() {  # name runner compiler…
  local folder=$work/$1 runner=$2 name=$1
  shift 2
  rm -rf "$folder" && mkdir -p "$folder" && cd "$folder" || return 1
  # Without fused operations, as src/codec/CMakeLists.txt has it.
  local flags=(-std=c++20 -ffp-contract=off -I"$here/../src/codec/include")
  [[ -n $glm_include ]] && flags+=(-isystem "$glm_include")
  printf '%s\0' "$here"/../src/codec/*.cpp "$here"/codec_hashes.cpp |
    xargs -0 -n 1 -P "$(nproc)" "$@" "${flags[@]}" -c || return 1
  "$@" ./*.o -o codec_hashes && timeout 300 $runner ./codec_hashes >"$work/$name.txt"
}

# A cross compiler does not look into /usr/include, where the header-only GLM lives.
glm_for_cross() {
  mkdir -p "$work/include"
  ln -sfn /usr/include/glm "$work/include/glm"
  echo "$work/include"
}

ran=0 failed=0
for tool in "${tools[@]}"; do
  IFS='|' read -r name runner command <<<"$tool"
  read -ra compiler <<<"$command"
  if ! command -v "${compiler[0]}" >/dev/null || { [[ -n $runner ]] && ! command -v "$runner" >/dev/null; }; then
    echo "$name: left out, ${compiler[0]} ${runner:+or $runner }is not installed"
    continue
  fi
  glm_include=
  [[ -n $runner ]] && glm_include=$(glm_for_cross)
  if ! (build_and_run "$name" "$runner" "${compiler[@]}"); then
    echo "$name: does not build or run"
    failed=1
    continue
  fi
  if ((ran == 0)) && [[ ${2:-} == --update ]]; then
    cp "$work/$name.txt" "$expected"
  fi
  ran=$((ran + 1))
  if diff "$expected" "$work/$name.txt" >"$work/$name.diff"; then
    echo "$name: $(wc -l <"$work/$name.txt") hashes equal"
  else
    echo "$name: differs from $expected:"
    head -n 10 "$work/$name.diff"
    failed=1
  fi
done
((failed == 0)) || exit 1
((ran > 1)) || exit 77
