# How targets are made, in lcm_tools alone and in Marco. Every compiler flag is set here.
#
#   marco_lcm_types(NAME PACKAGE p SOURCES a.lcm ...)     messages -> generated headers, as a SYSTEM target
#   marco_lcm_sources()                                   marco::lcm_sources: the text of all these .lcm files
#   marco_library(NAME SOURCES ... DEPENDS ... [PRIVATE ...])   libmarco_NAME, used as marco::NAME
#   marco_executable(NAME SOURCES ... DEPENDS ... [COMPONENT c])  an installed program, in the Debian package c
#   marco_test(NAME SOURCES ... DEPENDS ... [LABEL unit]) a GoogleTest program, one CTest case
#   marco_install_package(NAME CONFIG file ROOMS ...)     cmake --install, with a package config
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
# Includes begin with a room's name: "lcm_tools/...". This is the folder above.
cmake_path(GET CMAKE_CURRENT_LIST_DIR PARENT_PATH MARCO_LCM_TOOLS)
cmake_path(GET MARCO_LCM_TOOLS PARENT_PATH MARCO_INCLUDE_ROOT)
set(MARCO_ISOLATED ${MARCO_LCM_TOOLS}/tests/support/isolated.sh)

# Components are Debian packages. Where programs go that say nothing else, and libraries.
set(MARCO_PROGRAMS_COMPONENT marco-robot)
set(MARCO_LIBRARY_COMPONENT libmarco-robot-dev)

find_program(MARCO_CCACHE ccache)
if(MARCO_CCACHE)
  # ccache takes precompiled headers only with this setting. None of our sources uses the time macros.
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_SLOPPINESS=pch_defines,time_macros ${MARCO_CCACHE})
endif()
# Where it is there, trees with tests link in a fifth of the time.
find_program(MARCO_LLD ld.lld)
if(MARCO_LLD AND CMAKE_BUILD_TYPE MATCHES "^(Dev|Asan|Tsan|Fuzz)$")
  add_link_options(-fuse-ld=lld)
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
            # As fast as code that cannot be moved: nobody replaces our functions at run time.
            -fno-semantic-interposition
            # The same arithmetic on every machine: no fused multiply-add behind our back.
            -ffp-contract=off)
set_property(GLOBAL PROPERTY MARCO_LIBRARIES "")
add_custom_target(programs)
add_custom_target(unit_tests)
add_custom_target(long_tests)
add_custom_target(generated)

# marco_precompiled(TARGET KIND): with MARCO_PRECOMPILED, TARGET uses a precompiled header shared by all targets of one
# KIND (library, program, test; each has its own flags). MARCO_COMMON_TARGETS: what MARCO_MORE_HEADERS need.
set(MARCO_COMMON_HEADERS
    <algorithm> <array> <chrono> <cmath> <cstdint> <cstdio> <filesystem> <fstream> <functional> <limits> <map> <memory>
    <optional> <set> <span> <sstream> <stdexcept> <string> <string_view> <thread> <unordered_map> <utility> <vector>)
set(MARCO_HEADERS_library ${MARCO_COMMON_HEADERS} ${MARCO_MORE_HEADERS})
set(MARCO_HEADERS_program ${MARCO_HEADERS_library} <lcm/lcm-cpp.hpp> <spdlog/spdlog.h>)
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
    target_link_libraries(marco_headers_${kind} PRIVATE marco_options ${MARCO_COMMON_TARGETS} ${MARCO_LIBRARIES_${kind}})
    target_compile_options(marco_headers_${kind} PRIVATE ${MARCO_FLAGS_${kind}})
    target_precompile_headers(marco_headers_${kind} PRIVATE ${MARCO_HEADERS_${kind}})
    if(kind STREQUAL "library")
      set_target_properties(marco_headers_library PROPERTIES POSITION_INDEPENDENT_CODE ON)
    endif()
  endif()
  target_precompile_headers(${target} REUSE_FROM marco_headers_${kind})
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    target_compile_options(${target} PRIVATE -fpch-preprocess)  # for ccache
  endif()
endfunction()

function(marco_library name)
  cmake_parse_arguments(arg "" "" "SOURCES;DEPENDS;PRIVATE" ${ARGN})
  add_library(marco_${name} STATIC ${arg_SOURCES})
  add_library(marco::${name} ALIAS marco_${name})
  target_include_directories(
    marco_${name} PUBLIC $<BUILD_INTERFACE:${MARCO_INCLUDE_ROOT}>
                         $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/marco-robot>)
  target_link_libraries(marco_${name} PUBLIC ${arg_DEPENDS} PRIVATE $<BUILD_INTERFACE:marco_options>
                                                                    ${arg_PRIVATE})
  target_compile_features(marco_${name} PUBLIC cxx_std_20)
  # The Python module is a shared library made of these.
  set_target_properties(marco_${name} PROPERTIES EXPORT_NAME ${name} POSITION_INDEPENDENT_CODE ON)
  set_property(GLOBAL APPEND PROPERTY MARCO_LIBRARIES marco_${name})
  marco_precompiled(marco_${name} library)
endfunction()

# The commit of a build is a small object file. Programs link it but do not depend on it: a new commit relinks nothing,
# and a program linked for another reason carries the new commit.
function(marco_add_revision library)
  set(object ${CMAKE_BINARY_DIR}/revision.o)
  add_custom_command(
    OUTPUT ${object}
    COMMAND ${CMAKE_COMMAND} -DSOURCE=${CMAKE_SOURCE_DIR} -DCOMPILER=${CMAKE_CXX_COMPILER} -DOUT=${object} -P
            ${MARCO_LCM_TOOLS}/cmake/revision.cmake
    DEPENDS ${MARCO_LCM_TOOLS}/cmake/revision.cmake
    DEPFILE ${object}.d
    COMMENT "The commit"
    VERBATIM)
  add_custom_target(marco_revision DEPENDS ${object})
  add_dependencies(${library} marco_revision)
  target_link_options(${library} INTERFACE $<BUILD_INTERFACE:${object}>)
endfunction()

# A main only parses its command line, whose templates take the optimizer seconds.
set(MARCO_FLAGS_program $<$<CONFIG:Dev,Asan,Tsan>:-O0>)
function(marco_executable name)
  cmake_parse_arguments(arg "" "COMPONENT" "SOURCES;DEPENDS" ${ARGN})
  if(NOT arg_COMPONENT)
    set(arg_COMPONENT ${MARCO_PROGRAMS_COMPONENT})
  endif()
  add_executable(${name} ${arg_SOURCES})
  target_include_directories(${name} PRIVATE ${MARCO_INCLUDE_ROOT})
  target_link_libraries(${name} PRIVATE marco_options ${arg_DEPENDS})
  target_compile_options(${name} PRIVATE ${MARCO_FLAGS_program})
  marco_precompiled(${name} program)
  add_dependencies(programs ${name})
  set_property(GLOBAL APPEND PROPERTY MARCO_PROGRAMS_OF_${arg_COMPONENT} ${name})
  install(TARGETS ${name} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT ${arg_COMPONENT})
endfunction()

# SANITIZED_LATER: slow under the sanitizers; runs there with `./marco test --long` only.
# LABEL: unit (pure, under a second each, also run under the sanitizers), process (several processes, LCM in a network
# namespace), replay (real logs; SKIPPED without MARCO_TEST_DATA), long (built by the target long_tests only), peers (against
# other people's programs; built by targets that depend on it).
# Tests run in the folder of their project.
# SHARDS n: one program, n CTest cases that share its tests and run side by side; for programs that mostly wait. ALONE: the
# filter of tests that measure time; nothing else runs in parallel. BUSY: a process test that computes, rather than waits.
# `ctest -j` is given twice the number of cores: what computes takes two of these places, what waits takes one. The longest
# begin first, by their TIMEOUT.
function(marco_test name)
  cmake_parse_arguments(arg "SANITIZED_LATER;BUSY" "LABEL;TIMEOUT;SHARDS;ALONE" "SOURCES;DEPENDS" ${ARGN})
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
  target_include_directories(${name} PRIVATE ${MARCO_INCLUDE_ROOT})
  target_link_libraries(${name} PRIVATE marco_options ${arg_DEPENDS} GTest::gmock GTest::gtest_main)
  marco_precompiled(${name} test)
  if(arg_LABEL MATCHES "^(long|peers)$")
    set_target_properties(${name} PROPERTIES EXCLUDE_FROM_ALL TRUE)
  endif()
  if(arg_LABEL STREQUAL "long")
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
    set(command ${MARCO_ISOLATED} $<TARGET_FILE:${name}>)
  endif()
  # A match makes the whole program "skipped", whatever else it says: only one that passed may.
  set(skipped "SKIPPED: .*\\[  PASSED  \\] [0-9]+ tests?\\.\n(\\[  SKIPPED \\] [^\n]*\n)*\n*$")
  set(places 2)
  if(arg_LABEL STREQUAL "process" AND NOT arg_BUSY)
    set(places 1)
  endif()
  set(environment "MARCO_BIN=${CMAKE_RUNTIME_OUTPUT_DIRECTORY}")
  set(cases ${name})
  if(arg_SHARDS)
    set(cases "")
    foreach(shard RANGE 1 ${arg_SHARDS})
      list(APPEND cases ${name}_${shard})
    endforeach()
  endif()
  if(arg_ALONE)
    list(APPEND cases ${name}_alone)
  endif()
  set(shard 0)
  foreach(case ${cases})
    add_test(NAME ${case} COMMAND ${command} WORKING_DIRECTORY ${PROJECT_SOURCE_DIR})
    set(filter "")
    if(arg_ALONE)
      set(filter "GTEST_FILTER=-${arg_ALONE}")
    endif()
    if(case STREQUAL "${name}_alone")
      set(filter "GTEST_FILTER=${arg_ALONE}")
      set_tests_properties(${case} PROPERTIES RUN_SERIAL TRUE)
    elseif(arg_SHARDS)
      list(APPEND filter GTEST_TOTAL_SHARDS=${arg_SHARDS} GTEST_SHARD_INDEX=${shard})
      math(EXPR shard "${shard} + 1")
    endif()
    set_tests_properties(
      ${case} PROPERTIES LABELS "${arg_LABEL}" TIMEOUT ${arg_TIMEOUT} COST ${arg_TIMEOUT} PROCESSORS ${places} SKIP_REGULAR_EXPRESSION "${skipped}" SKIP_RETURN_CODE 77
                         ENVIRONMENT "${environment};${filter}")
  endforeach()
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
  # The Python module is a shared library made of these.
  set_target_properties(marco_${name} PROPERTIES EXPORT_NAME ${name} POSITION_INDEPENDENT_CODE ON)
  set_property(GLOBAL APPEND PROPERTY MARCO_LIBRARIES marco_${name})
endfunction()

# TESTS_ONLY: neither installed nor built into the programs.
function(marco_lcm_types name)
  cmake_parse_arguments(arg "TESTS_ONLY" "PACKAGE" "SOURCES" ${ARGN})
  set(folder ${CMAKE_CURRENT_BINARY_DIR}/generated)
  set(headers "")
  foreach(source ${arg_SOURCES})
    get_filename_component(type ${source} NAME_WE)
    list(APPEND headers ${folder}/${arg_PACKAGE}/${type}.hpp)
  endforeach()
  list(TRANSFORM arg_SOURCES PREPEND ${CMAKE_CURRENT_SOURCE_DIR}/)
  add_custom_command(
    OUTPUT ${headers}
    COMMAND lcm-gen --cpp --cpp-hpath ${folder} ${arg_SOURCES}
    # lcm-gen 1.3.1 trusts the lengths it reads: a negative or huge one makes decode() read or write out of bounds.
    # An element takes at least a byte, so a length beyond the bytes left is wrong.
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
  if(arg_TESTS_ONLY)
    return()
  endif()
  set_property(GLOBAL APPEND PROPERTY MARCO_LCM_SOURCES ${arg_SOURCES})
  # The Python module is a shared library made of these.
  set_target_properties(marco_${name} PROPERTIES EXPORT_NAME ${name} POSITION_INDEPENDENT_CODE ON)
  set_property(GLOBAL APPEND PROPERTY MARCO_LIBRARIES marco_${name})
  install(DIRECTORY ${folder}/${arg_PACKAGE} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/marco-robot COMPONENT ${MARCO_LIBRARY_COMPONENT})
  install(FILES ${arg_SOURCES} DESTINATION ${CMAKE_INSTALL_DATADIR}/marco-robot/lcmtypes/${arg_PACKAGE} COMPONENT ${MARCO_LIBRARY_COMPONENT})
endfunction()

# The text of every .lcm file above as a library, for tools that read types at run time. Call it after all marco_lcm_types.
function(marco_lcm_sources)
  set(out ${CMAKE_CURRENT_BINARY_DIR}/sources.cpp)
  get_property(files GLOBAL PROPERTY MARCO_LCM_SOURCES)
  list(JOIN files "|" joined)
  add_custom_command(
    OUTPUT ${out}
    COMMAND ${CMAKE_COMMAND} -DOUT=${out} "-DFILES=${joined}" -P ${MARCO_LCM_TOOLS}/cmake/embed_lcm.cmake
    DEPENDS ${files} ${MARCO_LCM_TOOLS}/cmake/embed_lcm.cmake
    VERBATIM)
  add_custom_target(marco_lcm_sources_text DEPENDS ${out})
  add_dependencies(generated marco_lcm_sources_text)
  marco_library(lcm_sources SOURCES ${out} DEPENDS marco::lcm_schema)
endfunction()

# CONFIG: the template of NAME-config.cmake. ROOMS: the folders whose headers are installed. EXCEPT: sub-folders that are not.
function(marco_install_package name)
  cmake_parse_arguments(arg "" "CONFIG" "ROOMS;EXCEPT" ${ARGN})
  list(TRANSFORM arg_EXCEPT REPLACE "(.+)" "PATTERN;\\1;EXCLUDE")
  set(folder ${CMAKE_INSTALL_LIBDIR}/cmake/${name})
  get_property(libraries GLOBAL PROPERTY MARCO_LIBRARIES)
  add_custom_target(libraries)
  add_dependencies(libraries ${libraries})
  install(TARGETS ${libraries} EXPORT ${name} ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT ${MARCO_LIBRARY_COMPONENT})
  install(EXPORT ${name} NAMESPACE marco:: FILE ${name}-targets.cmake DESTINATION ${folder} COMPONENT ${MARCO_LIBRARY_COMPONENT})
  foreach(room ${arg_ROOMS})
    install(
      DIRECTORY ${MARCO_INCLUDE_ROOT}/${room}/
      DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/marco-robot/${room}
      COMPONENT ${MARCO_LIBRARY_COMPONENT}
      FILES_MATCHING
      PATTERN "*.hpp"
      PATTERN tests EXCLUDE ${arg_EXCEPT})
  endforeach()
  configure_package_config_file(${arg_CONFIG} ${PROJECT_BINARY_DIR}/${name}-config.cmake INSTALL_DESTINATION ${folder})
  write_basic_package_version_file(${PROJECT_BINARY_DIR}/${name}-config-version.cmake COMPATIBILITY SameMinorVersion)
  install(FILES ${PROJECT_BINARY_DIR}/${name}-config.cmake ${PROJECT_BINARY_DIR}/${name}-config-version.cmake
          DESTINATION ${folder} COMPONENT ${MARCO_LIBRARY_COMPONENT})
endfunction()
