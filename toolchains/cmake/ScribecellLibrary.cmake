# SPDX-License-Identifier: Apache-2.0
# One library a folder, and the include rule made by the build itself: every library exports an include root of its own, a
# folder with one symbolic link to its sources. `#include "shared/geometry/vec.hpp"` compiles only where the target links
# shared_geometry; and sc_library refuses links that the rule forbids (host never firmware or a board, shared nothing above).

add_library(sc_warnings INTERFACE)
target_compile_options(sc_warnings INTERFACE
  -Werror -Wall -Wextra -Wpedantic -Wconversion -Wsign-conversion -Wshadow -Wdouble-promotion -Wswitch-enum -Wundef
  -Wcast-align -Wold-style-cast -Wnon-virtual-dtor)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  # At -O3 GCC 12 sees overlapping copies in std::string's operator+ where there are none (GCC bug 105651).
  target_compile_options(sc_warnings INTERFACE $<$<CONFIG:Release>:-Wno-restrict>)
endif()

# The control path: the same bits on every compiler and core.
add_library(sc_control_path INTERFACE)
target_compile_options(sc_control_path INTERFACE
  -fno-fast-math -ffp-contract=off -fno-math-errno -fno-exceptions -fno-rtti -fno-threadsafe-statics)
target_compile_definitions(sc_control_path INTERFACE EIGEN_DONT_VECTORIZE)

add_library(sc_sanitizers INTERFACE)
if(SC_SANITIZE)
  # vptr needs the run-time type information that the control path is built without.
  target_compile_options(sc_sanitizers INTERFACE -fsanitize=${SC_SANITIZE} -fno-sanitize-recover=all -fno-sanitize=vptr
    -fno-omit-frame-pointer)
  target_compile_definitions(sc_sanitizers INTERFACE _GLIBCXX_ASSERTIONS)
  target_link_options(sc_sanitizers INTERFACE -fsanitize=${SC_SANITIZE})
endif()

# What decodes bytes or reads files tells the fuzzer which way it went (tests/fuzz). In the build with the sanitizers alone,
# so that this costs no build of its own.
set(SC_FUZZED shared/link shared/machine shared/path shared/trace firmware/drives firmware/laser firmware/link
  firmware/recording firmware/sensors host/bridge host/formats host/pendant)

# Layers by top folder, and which an origin may link.
set(SC_MAY_LINK_shared shared)
set(SC_MAY_LINK_firmware shared firmware)
set(SC_MAY_LINK_boards shared firmware boards)
set(SC_MAY_LINK_host shared host)

function(sc_check_layer name folder deps)
  string(REGEX MATCH "^[^/]+" layer "${folder}")
  foreach(dep IN LISTS deps)
    if(dep MATCHES "^(shared|firmware|boards|host)_")
      if(NOT CMAKE_MATCH_1 IN_LIST SC_MAY_LINK_${layer})
        message(FATAL_ERROR "${folder} must not depend on ${dep}: ${layer} may use only ${SC_MAY_LINK_${layer}}")
      endif()
    endif()
  endforeach()
endfunction()

# Notes a target and its layer, for the tests that look at all of them (tests/lint/lint.cmake).
function(sc_record name folder list)
  string(REGEX MATCH "^[^/]+" layer "${folder}")
  set_target_properties(${name} PROPERTIES SC_LAYER "${layer}")
  set_property(GLOBAL APPEND PROPERTY ${list} ${name})
endfunction()

# sc_library(<folder> [SOURCES a.cpp ...] [DEPS shared_units ...] [PRIVATE_DEPS ...])
# The target is named after the folder: shared/geometry -> shared_geometry.
function(sc_library folder)
  cmake_parse_arguments(PARSE_ARGV 1 ARG "" "" "SOURCES;DEPS;PRIVATE_DEPS")
  string(REPLACE "/" "_" name "${folder}")
  set(dir "${PROJECT_SOURCE_DIR}/${folder}")
  sc_check_layer(${name} ${folder} "${ARG_DEPS};${ARG_PRIVATE_DEPS}")

  set(root "${PROJECT_BINARY_DIR}/include/${name}")
  get_filename_component(parent "${root}/${folder}" DIRECTORY)
  file(MAKE_DIRECTORY "${parent}")
  file(CREATE_LINK "${dir}" "${root}/${folder}" SYMBOLIC)

  if(ARG_SOURCES)
    list(TRANSFORM ARG_SOURCES PREPEND "${dir}/")
    add_library(${name} STATIC ${ARG_SOURCES})
    set(scope PUBLIC)
    target_link_libraries(${name} PRIVATE sc_warnings sc_sanitizers ${ARG_PRIVATE_DEPS})
    if(SC_FUZZ AND folder IN_LIST SC_FUZZED)
      target_compile_options(${name} PRIVATE -fsanitize=fuzzer-no-link)
    endif()
    if(folder MATCHES "^(shared|firmware)/")
      target_link_libraries(${name} PRIVATE sc_control_path)
    endif()
  else()
    add_library(${name} INTERFACE)
    set(scope INTERFACE)
  endif()
  target_include_directories(${name} ${scope} "${root}")
  target_link_libraries(${name} ${scope} ${ARG_DEPS})
  sc_record(${name} ${folder} SC_LIBRARIES)
endfunction()

# sc_program(<name> <folder> SOURCES ... DEPS ...): an executable of a layer.
function(sc_program name folder)
  cmake_parse_arguments(PARSE_ARGV 2 ARG "" "" "SOURCES;DEPS")
  sc_check_layer(${name} ${folder} "${ARG_DEPS}")
  list(TRANSFORM ARG_SOURCES PREPEND "${PROJECT_SOURCE_DIR}/${folder}/")
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE sc_warnings sc_sanitizers ${ARG_DEPS})
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/bin")
  sc_record(${name} ${folder} SC_PROGRAMS)
endfunction()

# sc_test(<name> LABEL unit SOURCES ... DEPS ... [TIMEOUT s]): a GoogleTest program; each case is a test of CTest.
# Left out of a build that has a layer it needs switched off (SC_HOST, SC_SIM).
function(sc_test name)
  cmake_parse_arguments(PARSE_ARGV 1 ARG "" "LABEL;TIMEOUT" "SOURCES;DEPS")
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 60)
  endif()
  if((NOT SC_HOST AND "${ARG_DEPS}" MATCHES "(^|;)host_") OR (NOT SC_SIM AND "${ARG_DEPS}" MATCHES "(^|;)boards_"))
    return()
  endif()
  if(SC_SANITIZE)
    math(EXPR ARG_TIMEOUT "${ARG_TIMEOUT} * 6")
  endif()
  set(root "${PROJECT_BINARY_DIR}/include/tests")  # what tests share: #include "tests/unit/..."
  file(MAKE_DIRECTORY "${root}")
  file(CREATE_LINK "${PROJECT_SOURCE_DIR}/tests" "${root}/tests" SYMBOLIC)
  add_executable(${name} ${ARG_SOURCES})
  target_include_directories(${name} PRIVATE "${root}")
  target_link_libraries(${name} PRIVATE sc_warnings sc_sanitizers ${ARG_DEPS} GTest::gtest GTest::gtest_main)
  target_compile_definitions(${name} PRIVATE SC_TEST_DATA="${PROJECT_SOURCE_DIR}/tests/data"
    SC_SOURCE_DIR="${PROJECT_SOURCE_DIR}" SC_BINARY_DIR="${PROJECT_BINARY_DIR}")
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/tests")
  gtest_discover_tests(${name} DISCOVERY_MODE PRE_TEST PROPERTIES LABELS ${ARG_LABEL} TIMEOUT ${ARG_TIMEOUT})
endfunction()
