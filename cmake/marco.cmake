# The ways a target is made in Marco. Every compiler flag lives here, once.
#
#   marco_lcm_types(NAME a.lcm ...)                       messages -> generated headers, as a SYSTEM target
#   marco_library(NAME SOURCES ... DEPENDS ... [PRIVATE ...])   libmarco_NAME, used as marco::NAME
#   marco_executable(NAME SOURCES ... DEPENDS ...)        an installed program
#   marco_test(NAME SOURCES ... DEPENDS ... [LABEL unit]) a GoogleTest program, one CTest case
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

find_program(MARCO_CCACHE ccache)
if(MARCO_CCACHE)
  # It asks for the word that precompiled headers are used with care: none of ours looks at the time.
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_SLOPPINESS=pch_defines,time_macros ${MARCO_CCACHE})
endif()
if(NOT CMAKE_RUNTIME_OUTPUT_DIRECTORY)
  set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
endif()

add_library(marco_options INTERFACE)
target_compile_features(marco_options INTERFACE cxx_std_20)
target_compile_options(
  marco_options
  INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion -Wdouble-promotion
            $<$<BOOL:${MARCO_WERROR}>:-Werror>
            -pthread
            # The same arithmetic on every machine: no fused multiply-add behind our back.
            -ffp-contract=off)
set_property(GLOBAL PROPERTY MARCO_LIBRARIES "")
add_custom_target(programs)
add_custom_target(unit_tests)
add_custom_target(long_tests)
add_custom_target(generated)

# marco_precompiled(TARGET KIND): with MARCO_PRECOMPILED, TARGET's files find the headers most of them begin with
# already parsed, once for all targets of a KIND (library, program, test: those have flags of their own).
set(MARCO_COMMON_HEADERS
    <algorithm> <array> <chrono> <cmath> <cstdint> <cstdio> <filesystem> <fstream> <functional> <limits> <map> <memory>
    <optional> <set> <span> <sstream> <stdexcept> <string> <string_view> <thread> <unordered_map> <utility> <vector>)
set(MARCO_HEADERS_library ${MARCO_COMMON_HEADERS} <Eigen/Core> <Eigen/Geometry> <Eigen/LU>)
set(MARCO_HEADERS_program ${MARCO_HEADERS_library} <CLI/CLI.hpp> <lcm/lcm-cpp.hpp> <spdlog/spdlog.h>)
set(MARCO_LIBRARIES_program marco::common_process)
set(MARCO_HEADERS_test ${MARCO_HEADERS_library} <gmock/gmock.h> <gtest/gtest.h> <random>)
set(MARCO_LIBRARIES_test GTest::gmock)
function(marco_precompiled target kind)
  if(NOT MARCO_PRECOMPILED)
    return()
  endif()
  if(NOT TARGET marco_headers_${kind})
    file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/headers/${kind}.cpp CONTENT "")
    add_library(marco_headers_${kind} OBJECT EXCLUDE_FROM_ALL ${CMAKE_BINARY_DIR}/headers/${kind}.cpp)
    target_link_libraries(marco_headers_${kind} PRIVATE marco_options Eigen3::Eigen ${MARCO_LIBRARIES_${kind}})
    target_compile_options(marco_headers_${kind} PRIVATE ${MARCO_FLAGS_${kind}})
    target_precompile_headers(marco_headers_${kind} PRIVATE ${MARCO_HEADERS_${kind}})
  endif()
  target_precompile_headers(${target} REUSE_FROM marco_headers_${kind})
  target_compile_options(${target} PRIVATE -fpch-preprocess)  # for ccache
endfunction()

function(marco_library name)
  cmake_parse_arguments(arg "" "" "SOURCES;DEPENDS;PRIVATE" ${ARGN})
  add_library(marco_${name} STATIC ${arg_SOURCES})
  add_library(marco::${name} ALIAS marco_${name})
  target_include_directories(
    marco_${name} PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>
                         $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/marco-robot>)
  target_link_libraries(marco_${name} PUBLIC ${arg_DEPENDS} PRIVATE $<BUILD_INTERFACE:marco_options>
                                                                    ${arg_PRIVATE})
  target_compile_features(marco_${name} PUBLIC cxx_std_20)
  set_target_properties(marco_${name} PROPERTIES EXPORT_NAME ${name})
  set_property(GLOBAL APPEND PROPERTY MARCO_LIBRARIES marco_${name})
  marco_precompiled(marco_${name} library)
endfunction()

# The commit of a build is one small object file that programs are linked with but do not depend on: a commit relinks
# nothing, and what is linked again for another reason says the new one.
function(marco_add_revision library)
  set(object ${CMAKE_BINARY_DIR}/revision.o)
  add_custom_command(
    OUTPUT ${object}
    COMMAND ${CMAKE_COMMAND} -DSOURCE=${PROJECT_SOURCE_DIR} -DCOMPILER=${CMAKE_CXX_COMPILER} -DOUT=${object} -P
            ${PROJECT_SOURCE_DIR}/cmake/revision.cmake
    DEPENDS ${PROJECT_SOURCE_DIR}/cmake/revision.cmake
    DEPFILE ${object}.d
    COMMENT "The commit"
    VERBATIM)
  add_custom_target(marco_revision DEPENDS ${object})
  add_dependencies(${library} marco_revision)
  target_link_options(${library} INTERFACE $<BUILD_INTERFACE:${object}>)
endfunction()

# A main is glue, and a command line's templates take the optimizer seconds.
set(MARCO_FLAGS_program $<$<CONFIG:Dev,Asan,Tsan>:-O0>)
function(marco_executable name)
  cmake_parse_arguments(arg "" "" "SOURCES;DEPENDS" ${ARGN})
  add_executable(${name} ${arg_SOURCES})
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR})
  target_link_libraries(${name} PRIVATE marco_options ${arg_DEPENDS})
  target_compile_options(${name} PRIVATE ${MARCO_FLAGS_program})
  marco_precompiled(${name} program)
  add_dependencies(programs ${name})
  install(TARGETS ${name} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endfunction()

# SANITIZED_LATER: slow to build or to run there; goes under the sanitizers in `./marco test --long`, not on every change.
# LABEL: unit (pure, under a second each, also run under the sanitizers), process (several processes,
# LCM in a network namespace), replay (real logs; SKIPPED without MARCO_TEST_DATA), long (built by the target
# long_tests only).
function(marco_test name)
  cmake_parse_arguments(arg "SANITIZED_LATER" "LABEL;TIMEOUT" "SOURCES;DEPENDS" ${ARGN})
  if(NOT arg_LABEL)
    set(arg_LABEL unit)
  endif()
  if(NOT arg_TIMEOUT)
    set(arg_TIMEOUT 300)  # against hanging: a busy machine takes several times as long as an idle one
  endif()
  if(CMAKE_BUILD_TYPE MATCHES "^(Asan|Tsan)$")
    math(EXPR arg_TIMEOUT "10 * ${arg_TIMEOUT}")
  endif()
  add_executable(${name} ${arg_SOURCES})
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR})
  target_link_libraries(${name} PRIVATE marco_options ${arg_DEPENDS} GTest::gmock GTest::gtest_main)
  marco_precompiled(${name} test)
  if(arg_LABEL STREQUAL "long")
    set_target_properties(${name} PROPERTIES EXCLUDE_FROM_ALL TRUE)
    add_dependencies(long_tests ${name})
  endif()
  if(arg_LABEL STREQUAL "unit")
    if(arg_SANITIZED_LATER)
      list(APPEND arg_LABEL sanitized_later)
    else()
      add_dependencies(unit_tests ${name})
    endif()
    set(command ${name})
  else()
    set(command ${PROJECT_SOURCE_DIR}/tests/support/isolated.sh $<TARGET_FILE:${name}>)
  endif()
  add_test(NAME ${name} COMMAND ${command} WORKING_DIRECTORY ${PROJECT_SOURCE_DIR})
  # A match makes the whole program "skipped", whatever else it says: only one that passed may.
  set(skipped "SKIPPED: .*\\[  PASSED  \\] [0-9]+ tests?\\.\n(\\[  SKIPPED \\] [^\n]*\n)*\n*$")
  set_tests_properties(
    ${name} PROPERTIES LABELS "${arg_LABEL}" TIMEOUT ${arg_TIMEOUT} SKIP_REGULAR_EXPRESSION
                       "${skipped}" ENVIRONMENT "MARCO_BIN=${CMAKE_RUNTIME_OUTPUT_DIRECTORY}")
endfunction()

# marco_system_library(NAME [HEADER h [FOLDERS f]]): a library of the system without a CMake config of its
# own, found by its name, as marco::NAME. Installed, it is linked by name.
function(marco_system_library name)
  cmake_parse_arguments(arg "" "HEADER" "FOLDERS" ${ARGN})
  if(TARGET marco_${name})
    return()
  endif()
  find_library(MARCO_LIBRARY_${name} ${name} REQUIRED)
  add_library(marco_${name} INTERFACE)
  add_library(marco::${name} ALIAS marco_${name})
  target_link_libraries(marco_${name} INTERFACE $<BUILD_INTERFACE:${MARCO_LIBRARY_${name}}> $<INSTALL_INTERFACE:${name}>)
  if(arg_HEADER)
    find_path(MARCO_INCLUDE_${name} ${arg_HEADER} PATH_SUFFIXES ${arg_FOLDERS} REQUIRED)
    target_include_directories(marco_${name} SYSTEM INTERFACE $<BUILD_INTERFACE:${MARCO_INCLUDE_${name}}>)
  endif()
  set_target_properties(marco_${name} PROPERTIES EXPORT_NAME ${name})
  set_property(GLOBAL APPEND PROPERTY MARCO_LIBRARIES marco_${name})
endfunction()

function(marco_lcm_types name)
  cmake_parse_arguments(arg "" "PACKAGE" "SOURCES" ${ARGN})
  set(folder ${CMAKE_CURRENT_BINARY_DIR}/generated)
  set(headers "")
  foreach(source ${arg_SOURCES})
    get_filename_component(type ${source} NAME_WE)
    list(APPEND headers ${folder}/${arg_PACKAGE}/${type}.hpp)
  endforeach()
  list(TRANSFORM arg_SOURCES PREPEND ${CMAKE_CURRENT_SOURCE_DIR}/)
  set_property(GLOBAL APPEND PROPERTY MARCO_LCM_SOURCES ${arg_SOURCES})
  add_custom_command(
    OUTPUT ${headers}
    COMMAND lcm-gen --cpp --cpp-hpath ${folder} ${arg_SOURCES}
    # lcm-gen 1.3.1 trusts the lengths it reads: a negative or huge one makes decode() write or read out of
    # bounds. An element takes at least a byte, so a length beyond the bytes left is a lie.
    COMMAND sed -i -E -e "s/^( *)(this->[^;]*\\.resize\\((this->[a-zA-Z0-9_]+)\\)\;)$/\\1if(\\3 < 0 || \\3 > maxlen - pos) return -1\;\\n\\1\\2/"
            -e "s/if\\((__[a-zA-Z0-9_]+_len_*) > maxlen - pos\\)/if(\\1 < 1 || \\1 > maxlen - pos)/" ${headers}
    DEPENDS ${arg_SOURCES}
    COMMENT "lcm-gen ${arg_PACKAGE}"
    VERBATIM)
  add_custom_target(marco_${name}_headers DEPENDS ${headers})
  add_dependencies(generated marco_${name}_headers)
  add_library(marco_${name} INTERFACE)
  add_library(marco::${name} ALIAS marco_${name})
  add_dependencies(marco_${name} marco_${name}_headers)
  target_include_directories(marco_${name} SYSTEM INTERFACE $<BUILD_INTERFACE:${folder}>
                                                            $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/marco-robot>)
  target_link_libraries(marco_${name} INTERFACE PkgConfig::LCM)
  # LCM's lcm_coretypes.h reads and writes doubles through int64_t pointers; with strict aliasing the
  # optimizer may drop those writes, and a decoded message is all zeros.
  target_compile_options(marco_${name} INTERFACE -fno-strict-aliasing)
  set_target_properties(marco_${name} PROPERTIES EXPORT_NAME ${name})
  set_property(GLOBAL APPEND PROPERTY MARCO_LIBRARIES marco_${name})
  install(DIRECTORY ${folder}/${arg_PACKAGE} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/marco-robot)
  install(FILES ${arg_SOURCES} DESTINATION ${CMAKE_INSTALL_DATADIR}/marco-robot/lcmtypes/${arg_PACKAGE})
endfunction()

# The front door and what it reads, laid out as in the sources. Debian's `marco` is a window manager: ours is marco-robot.
function(marco_install_front_door)
  set(share ${CMAKE_INSTALL_DATADIR}/marco-robot)
  install(PROGRAMS ${PROJECT_SOURCE_DIR}/marco DESTINATION ${CMAKE_INSTALL_BINDIR} RENAME marco-robot)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/config DESTINATION ${share})
  install(PROGRAMS ${PROJECT_SOURCE_DIR}/tests/support/isolated.sh DESTINATION ${share}/tests/support)
  foreach(script packages build help demo)
    install(FILES ${PROJECT_SOURCE_DIR}/tools/${script}.sh DESTINATION ${share}/tools)
  endforeach()
  install(PROGRAMS ${PROJECT_SOURCE_DIR}/tools/record.sh DESTINATION ${share}/tools)
  # $MARCO_ROOT/marco in procman scripts.
  file(RELATIVE_PATH to_bin /${share} /${CMAKE_INSTALL_BINDIR}/marco-robot)
  file(CREATE_LINK ${to_bin} ${PROJECT_BINARY_DIR}/marco SYMBOLIC)
  install(FILES ${PROJECT_BINARY_DIR}/marco DESTINATION ${share})
endfunction()

# `cmake --install` with a package config: find_package(marco), then marco::common, marco::slam, ...
function(marco_install_package)
  get_property(libraries GLOBAL PROPERTY MARCO_LIBRARIES)
  install(TARGETS ${libraries} EXPORT marco ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
  install(
    EXPORT marco
    NAMESPACE marco::
    FILE marco-targets.cmake
    DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/marco)
  foreach(room lcm_tools common lcmtypes recordings drivers simulator teleop slam mapping3d viewer tools)
    install(
      DIRECTORY ${PROJECT_SOURCE_DIR}/${room}
      DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/marco-robot
      FILES_MATCHING
      PATTERN "*.hpp")
  endforeach()
  marco_install_front_door()
  configure_package_config_file(
    ${PROJECT_SOURCE_DIR}/cmake/marco-config.cmake.in ${PROJECT_BINARY_DIR}/marco-config.cmake
    INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/marco)
  write_basic_package_version_file(${PROJECT_BINARY_DIR}/marco-config-version.cmake
                                   COMPATIBILITY SameMinorVersion)
  install(FILES ${PROJECT_BINARY_DIR}/marco-config.cmake
                ${PROJECT_BINARY_DIR}/marco-config-version.cmake
          DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/marco)
endfunction()
