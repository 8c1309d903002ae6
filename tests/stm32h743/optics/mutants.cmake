# SPDX-License-Identifier: Apache-2.0
# Ablation of the waveforms: one rule is taken out of a copy of the driver, and its tests must fail.
add_library(stm32h743_galvo_tests OBJECT "${CMAKE_CURRENT_LIST_DIR}/galvo_wave_test.cpp")
target_link_libraries(stm32h743_galvo_tests PRIVATE sc_warnings sc_sanitizers boards_stm32h743_optics
  stm32h743_optics_model GTest::gtest)

function(sc_galvo_mutant name from to)
  set(source "${PROJECT_SOURCE_DIR}/boards/stm32h743/optics/galvo_wave.cpp")
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${source}")
  file(READ "${source}" text)
  string(REPLACE "${from}" "${to}" mutant "${text}")
  if(mutant STREQUAL text)
    message(FATAL_ERROR "galvo mutant ${name}: there is no '${from}' to take out")
  endif()
  set(out "${PROJECT_BINARY_DIR}/galvo_mutants/${name}.cpp")
  file(CONFIGURE OUTPUT "${out}" CONTENT "${mutant}" @ONLY)
  add_executable(galvo_mutant_${name} $<TARGET_OBJECTS:stm32h743_galvo_tests> "${out}")
  target_link_libraries(galvo_mutant_${name} PRIVATE sc_warnings sc_sanitizers boards_stm32h743_optics
    stm32h743_optics_model GTest::gtest GTest::gtest_main)
  set_target_properties(galvo_mutant_${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/tests")
  add_test(NAME unit.galvo_mutant_${name} COMMAND galvo_mutant_${name} --gtest_brief=1)
  set_tests_properties(unit.galvo_mutant_${name} PROPERTIES LABELS unit WILL_FAIL TRUE TIMEOUT 60)
endfunction()

sc_galvo_mutant(swap_unchecked "held != Next::open;\n}" "true;\n}")
sc_galvo_mutant(never_repeats "words <= kDeadlineWords" "words == 0")
sc_galvo_mutant(address_in_play "const unsigned coming = 1 - playing()" "const unsigned coming = playing()")
sc_galvo_mutant(enabled_first "write32(kStream + dma::kPar, optics_port::kBsrr);"
  "write32(kStream + dma::kCr, kSettings | dma::kEnable);\n    write32(kStream + dma::kPar, optics_port::kBsrr);")
sc_galvo_mutant(flags_stand "write32(dma::kLifcr, dma::kAllFlags);" "")
sc_galvo_mutant(asks_before_update "write32(tim6::kEgr, tim6::kGenerateUpdate);"
  "write32(tim6::kDier, tim6::kUpdateDma);\n    write32(tim6::kEgr, tim6::kGenerateUpdate);")
sc_galvo_mutant(sync_high "left == 1 ? rise ^ kSyncLow : rise" "(left > kGalvoBits) ? rise ^ kSyncLow : rise")
sc_galvo_mutant(last_bit_first "(words.x >> (left - 1))" "(words.x >> (kGalvoBits - left))")
sc_galvo_mutant(gate_stays_open "shut_ = true;\n        ++underruns_" "++underruns_")
