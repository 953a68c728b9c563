# Writes build_info.h: commit, compiler and flags, which every figure is printed with. Run at build time, so that the
# commit is that of the sources being built; the file is touched only when it changes.
cmake_minimum_required(VERSION 3.25)

execute_process(COMMAND git -C ${SOURCE_DIR} describe --always --dirty --abbrev=12
                OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
if(NOT commit)
  set(commit "no commit")
endif()
file(CONFIGURE OUTPUT ${OUTPUT} CONTENT "#pragma once
namespace tsc::bench {
inline constexpr const char* kCommit = \"@commit@\";
inline constexpr const char* kCompiler = \"@COMPILER@\";
inline constexpr const char* kFlags = \"@FLAGS@\";
inline constexpr const char* kDefaultCacheFolder = \"@CACHE@\";
}  // namespace tsc::bench
" @ONLY)
