# Installs the program, the libraries with their public headers, and what find_package(gltf-tsc) needs. Each library is
# a component with a target file of its own, so that whoever wants the codec alone needs none of the others' packages.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(config_dir ${CMAKE_INSTALL_LIBDIR}/cmake/gltf-tsc)
set(components "")
foreach(library tsc_codec tsc_gltf tsc_tinygltf tsc_quality)
  if(TARGET ${library})
    list(APPEND components ${library})
    target_compile_features(${library} PUBLIC cxx_std_20)  # the headers need it, whatever a consumer's default is
    install(TARGETS ${library} EXPORT gltf-tsc-${library}
      ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
    install(EXPORT gltf-tsc-${library} NAMESPACE gltf-tsc:: DESTINATION ${config_dir} FILE ${library}-targets.cmake)
  endif()
endforeach()

foreach(part codec gltf quality)
  if(EXISTS ${PROJECT_SOURCE_DIR}/src/${part}/include)
    install(DIRECTORY ${PROJECT_SOURCE_DIR}/src/${part}/include/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
  endif()
endforeach()

if(TARGET gltf-tsc)
  install(TARGETS gltf-tsc RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endif()

configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/gltf-tscConfig.cmake.in
  ${PROJECT_BINARY_DIR}/gltf-tscConfig.cmake INSTALL_DESTINATION ${config_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/gltf-tscConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/gltf-tscConfig.cmake ${PROJECT_BINARY_DIR}/gltf-tscConfigVersion.cmake
  DESTINATION ${config_dir})
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE ${PROJECT_SOURCE_DIR}/README.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
