# Nearly all of the time that these targets take to compile goes into JSON, CLI11 and GoogleTest. Several files to a
# compiler run, split so that two processors share them, make that a third. GLTF_TSC_UNITY=OFF compiles each file alone:
# better for work on them, and it shows includes that a file forgot.
option(GLTF_TSC_UNITY "Compile several files at a time where that is much faster" ${PROJECT_IS_TOP_LEVEL})
foreach(target gltf-tsc tsc_gltf_tests tsc_quality_tests)
  if(GLTF_TSC_UNITY AND TARGET ${target})
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 6)
  endif()
endforeach()
