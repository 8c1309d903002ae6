# SPDX-License-Identifier: Apache-2.0
# Does the net catch? Real control code is broken on purpose, a break at a time, and the checks that guard the same bits
# must find each. The log that the breaks are judged by is also that of the whole matrix (hashes.cmake).
if(SC_SANITIZE OR NOT TARGET scribecell-replay OR NOT TARGET boards_sim)
  return()
endif()
find_package(Python3 REQUIRED COMPONENTS Interpreter)

file(MAKE_DIRECTORY "${PROJECT_BINARY_DIR}/include/tests")
file(CREATE_LINK "${PROJECT_SOURCE_DIR}/tests" "${PROJECT_BINARY_DIR}/include/tests/tests" SYMBOLIC)
add_executable(matrix_record "${CMAKE_CURRENT_LIST_DIR}/record.cpp"
  "${PROJECT_SOURCE_DIR}/tests/sim/firmware/controller/cell_rig.cpp")
target_include_directories(matrix_record PRIVATE "${PROJECT_BINARY_DIR}/include/tests")
target_compile_definitions(matrix_record PRIVATE SC_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
target_link_libraries(matrix_record PRIVATE sc_warnings boards_mps2_an500_pc boards_sim shared_link shared_path shared_trace shared_hash)
set_target_properties(matrix_record PROPERTIES RUNTIME_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/tests")

set(sc_matrix_log "${PROJECT_BINARY_DIR}/matrix/short.rec")
add_test(NAME matrix.record COMMAND matrix_record "${sc_matrix_log}")
set_tests_properties(matrix.record PROPERTIES LABELS matrix TIMEOUT 120 FIXTURES_SETUP matrix_log)

if(NOT CMAKE_CXX_COMPILER_ID STREQUAL "GNU" OR NOT CMAKE_SYSTEM_PROCESSOR STREQUAL "x86_64")
  return()
endif()

# sc_broken_source(<name> SOURCE file.cpp [FILE file FROM text TO text] [FLAGS ...]): an object library break_<name> of one
# source of the control path, with FROM replaced by TO in FILE (the source itself, or a header), or with other flags.
function(sc_broken_source name)
  cmake_parse_arguments(PARSE_ARGV 1 ARG "" "SOURCE;FILE;FROM;TO" "FLAGS")
  if(NOT EXISTS "${PROJECT_SOURCE_DIR}/${ARG_SOURCE}")
    message(FATAL_ERROR "tests/matrix/breaks.cmake: ${ARG_SOURCE} is gone; break another source of the control path")
  endif()
  set(copies "${PROJECT_BINARY_DIR}/breaks/${name}")
  set(source "${PROJECT_SOURCE_DIR}/${ARG_SOURCE}")
  if(ARG_FILE)
    add_custom_command(OUTPUT "${copies}/${ARG_FILE}"
      COMMAND Python3::Interpreter -B "${PROJECT_SOURCE_DIR}/tests/matrix/patch.py" "${PROJECT_SOURCE_DIR}/${ARG_FILE}"
        "${copies}/${ARG_FILE}" "${ARG_FROM}" "${ARG_TO}"
      DEPENDS "${PROJECT_SOURCE_DIR}/${ARG_FILE}" "${PROJECT_SOURCE_DIR}/tests/matrix/patch.py" VERBATIM)
    if(ARG_FILE STREQUAL ARG_SOURCE)
      set(source "${copies}/${ARG_SOURCE}")
    endif()
    set(patched "${copies}/${ARG_FILE}")
  endif()
  add_library(break_${name} OBJECT "${source}" ${patched})
  target_include_directories(break_${name} BEFORE PRIVATE "${copies}")
  # Only what it includes; the options of the control path are repeated, so that those of the break come behind them.
  target_link_libraries(break_${name} PRIVATE firmware_controller)
  get_target_property(options sc_control_path INTERFACE_COMPILE_OPTIONS)
  target_compile_options(break_${name} PRIVATE ${options} ${ARG_FLAGS})
endfunction()

# sc_break(<name> NEEDS flags ...): a replay program with such a source in place of the right one. The matrix must find it.
function(sc_break name)
  cmake_parse_arguments(PARSE_ARGV 1 ARG "" "NEEDS" "")
  sc_broken_source(${name} ${ARG_UNPARSED_ARGUMENTS})
  add_executable(replay_break_${name} $<TARGET_OBJECTS:scribecell-replay> $<TARGET_OBJECTS:break_${name}>)
  target_link_libraries(replay_break_${name} PRIVATE boards_replay)
  set_target_properties(replay_break_${name} PROPERTIES LINKER_LANGUAGE CXX
    RUNTIME_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/tests")
  add_test(NAME matrix.break_${name} COMMAND Python3::Interpreter -B "${PROJECT_SOURCE_DIR}/tests/matrix/hashes.py"
    "${sc_matrix_log}" --build right $<TARGET_FILE:scribecell-replay> --build ${name} $<TARGET_FILE:replay_break_${name}>
    --must-differ ${name})
  set_tests_properties(matrix.break_${name} PROPERTIES LABELS matrix TIMEOUT 120 FIXTURES_REQUIRED matrix_log)
endfunction()

sc_break(fma SOURCE firmware/motion/axis_geometry.cpp FLAGS -mfma -ffp-contract=fast)

# -ffast-math lets the compiler sum in another order, which is what a vectorised sum is.
sc_break(vectorised_sum SOURCE firmware/controller/job_runner.cpp FLAGS -O3 -ffast-math)

sc_break(uninitialised SOURCE firmware/controller/controller.cpp FILE firmware/controller/controller.hpp
  FROM "bool pulses_before_ = false;" TO "bool pulses_before_;")

# A call of the mathematics library need not differ on this machine: the list of allowed symbols forbids it.
sc_broken_source(libm SOURCE firmware/controller/job_runner.cpp FILE firmware/controller/job_runner.cpp
  FROM "return exact_double(ticks * machine_.control_period_ns) * 1e-9;"
  TO "return __builtin_sin(exact_double(ticks * machine_.control_period_ns) * 1e-9);")
add_library(break_libm_archive STATIC $<TARGET_OBJECTS:break_libm>)
set_target_properties(break_libm_archive PROPERTIES LINKER_LANGUAGE CXX)
set(sc_archives_with_libm "$<TARGET_FILE:break_libm_archive>")
get_property(sc_all_libraries GLOBAL PROPERTY SC_LIBRARIES)
foreach(target IN LISTS sc_all_libraries)
  get_target_property(layer ${target} SC_LAYER)
  get_target_property(type ${target} TYPE)
  if(type STREQUAL "STATIC_LIBRARY" AND layer MATCHES "^(shared|firmware)$")
    list(APPEND sc_archives_with_libm $<TARGET_FILE:${target}>)
  endif()
endforeach()
add_test(NAME matrix.break_libm COMMAND Python3::Interpreter -B "${PROJECT_SOURCE_DIR}/tests/lint/symbols.py"
  ${sc_archives_with_libm})
set_tests_properties(matrix.break_libm PROPERTIES LABELS matrix TIMEOUT 60 PASS_REGULAR_EXPRESSION "needs 'sin'")
