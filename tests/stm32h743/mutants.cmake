# SPDX-License-Identifier: Apache-2.0
# Ablation of drivers: one rule is taken out of a copy of a driver, and its tests must fail.

# folder: below boards/stm32h743; LIBRARIES: driver, model and what its tests need; PARTS: drivers, each PART.cpp with its
# PART_test.cpp beside this list, or with the file TESTS.
function(sc_h743_mutants folder)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "TESTS" "LIBRARIES;PARTS")
  set_property(GLOBAL PROPERTY sc_h743_${folder} "${arg_LIBRARIES};GTest::gtest")
  foreach(part IN LISTS arg_PARTS)
    set(tests "${CMAKE_CURRENT_LIST_DIR}/${part}_test.cpp")
    if(arg_TESTS)
      set(tests "${arg_TESTS}")
    endif()
    add_library(stm32h743_${part}_tests OBJECT "${tests}")
    target_compile_definitions(stm32h743_${part}_tests PRIVATE SC_SOURCE_DIR="${PROJECT_SOURCE_DIR}"
      SC_TEST_DATA="${PROJECT_SOURCE_DIR}/tests/data")
    target_link_libraries(stm32h743_${part}_tests PRIVATE sc_warnings sc_sanitizers ${arg_LIBRARIES} GTest::gtest)
  endforeach()
endfunction()

# part: of whose driver and tests; name: of the mutant; from, to: texts.
function(sc_h743_mutant folder part name from to)
  set(source "${PROJECT_SOURCE_DIR}/boards/stm32h743/${folder}/${part}.cpp")
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${source}")
  file(READ "${source}" text)
  string(REPLACE "${from}" "${to}" mutant "${text}")
  if(mutant STREQUAL text)
    message(FATAL_ERROR "${part} mutant ${name}: there is no '${from}' to take out")
  endif()
  set(out "${PROJECT_BINARY_DIR}/${part}_mutants/${name}.cpp")
  file(CONFIGURE OUTPUT "${out}" CONTENT "${mutant}" @ONLY)
  get_property(libraries GLOBAL PROPERTY sc_h743_${folder})
  # Objects of the program itself come before those of the library.
  add_executable(${part}_mutant_${name} $<TARGET_OBJECTS:stm32h743_${part}_tests> "${out}")
  target_link_libraries(${part}_mutant_${name} PRIVATE sc_warnings sc_sanitizers ${libraries} GTest::gtest_main)
  # What a rule was for may be unused without it.
  set_source_files_properties("${out}" PROPERTIES COMPILE_OPTIONS "-Wno-unused;-Wno-unused-parameter")
  set_target_properties(${part}_mutant_${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/tests")
  add_test(NAME unit.${part}_mutant_${name} COMMAND ${part}_mutant_${name} --gtest_brief=1 --gtest_fail_fast)
  set_tests_properties(unit.${part}_mutant_${name} PROPERTIES LABELS unit WILL_FAIL TRUE TIMEOUT 60)
endfunction()
