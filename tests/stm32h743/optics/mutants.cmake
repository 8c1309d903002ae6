# SPDX-License-Identifier: Apache-2.0
# Ablation of the waveforms: one rule is taken out of a copy of the driver, and its tests must fail.
# `part`: of whose driver and tests.
foreach(part galvo_wave gate_wave safety_lines)
  add_library(stm32h743_${part}_tests OBJECT "${CMAKE_CURRENT_LIST_DIR}/${part}_test.cpp")
  target_link_libraries(stm32h743_${part}_tests PRIVATE sc_warnings sc_sanitizers boards_stm32h743_optics
    stm32h743_optics_model GTest::gtest)
endforeach()

function(sc_optics_mutant part name from to)
  set(source "${PROJECT_SOURCE_DIR}/boards/stm32h743/optics/${part}.cpp")
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${source}")
  file(READ "${source}" text)
  string(REPLACE "${from}" "${to}" mutant "${text}")
  if(mutant STREQUAL text)
    message(FATAL_ERROR "${part} mutant ${name}: there is no '${from}' to take out")
  endif()
  set(out "${PROJECT_BINARY_DIR}/${part}_mutants/${name}.cpp")
  file(CONFIGURE OUTPUT "${out}" CONTENT "${mutant}" @ONLY)
  add_executable(${part}_mutant_${name} $<TARGET_OBJECTS:stm32h743_${part}_tests> "${out}")
  target_link_libraries(${part}_mutant_${name} PRIVATE sc_warnings sc_sanitizers boards_stm32h743_optics
    stm32h743_optics_model GTest::gtest GTest::gtest_main)
  # What a rule was for may be unused without it.
  set_source_files_properties("${out}" PROPERTIES COMPILE_OPTIONS -Wno-unused)
  set_target_properties(${part}_mutant_${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/tests")
  add_test(NAME unit.${part}_mutant_${name} COMMAND ${part}_mutant_${name} --gtest_brief=1)
  set_tests_properties(unit.${part}_mutant_${name} PROPERTIES LABELS unit WILL_FAIL TRUE TIMEOUT 60)
endfunction()

sc_optics_mutant(galvo_wave swap_unchecked "held != Next::open;\n}" "true;\n}")
sc_optics_mutant(galvo_wave never_repeats "words <= kDeadlineWords" "words == 0")
sc_optics_mutant(galvo_wave address_in_play "const unsigned coming = 1 - playing()" "const unsigned coming = playing()")
sc_optics_mutant(galvo_wave enabled_first "write32(kStream + dma::kPar, optics_port::kBsrr);"
  "write32(kStream + dma::kCr, kSettings | dma::kEnable);\n    write32(kStream + dma::kPar, optics_port::kBsrr);")
sc_optics_mutant(galvo_wave flags_stand "write32(dma::kLifcr, dma::kAllFlags);" "")
sc_optics_mutant(galvo_wave asks_before_update "write32(tim6::kEgr, tim6::kGenerateUpdate);"
  "write32(tim6::kDier, tim6::kUpdateDma);\n    write32(tim6::kEgr, tim6::kGenerateUpdate);")
sc_optics_mutant(galvo_wave sync_high "left == 1 ? rise ^ kSyncLow : rise" "(left > kGalvoBits) ? rise ^ kSyncLow : rise")
sc_optics_mutant(galvo_wave last_bit_first "(words.x >> (left - 1))" "(words.x >> (kGalvoBits - left))")
sc_optics_mutant(galvo_wave gate_stays_open "shut_ = true;\n        ++underruns_" "++underruns_")

sc_optics_mutant(gate_wave compare_at_once "tim1::first_mode(tim1::kCombinedPwm1) | tim1::kFirstPreload |"
  "tim1::first_mode(tim1::kCombinedPwm1) |")
sc_optics_mutant(gate_wave reload_at_once "write32(tim1::kCr1, tim1::kCounterEnable | tim1::kReloadPreload);"
  "write32(tim1::kCr1, tim1::kCounterEnable);")
sc_optics_mutant(gate_wave no_first_update "write32(tim1::kEgr, tim1::kGenerateUpdate);" "")
sc_optics_mutant(gate_wave repeats_off_by_one "segment.repeats)" "segment.repeats + 1U)")
sc_optics_mutant(gate_wave asks_before_update "write32(tim1::kEgr, tim1::kGenerateUpdate);"
  "write32(tim1::kDier, tim1::kUpdateDma);\n    write32(tim1::kEgr, tim1::kGenerateUpdate);")
sc_optics_mutant(gate_wave no_break "kOff = tim1::kBreakEnable | " "kOff = ")
sc_optics_mutant(gate_wave break_high "kOff = tim1::kBreakEnable" "kOff = tim1::kBreakEnable | tim1::kBreakHigh")
sc_optics_mutant(gate_wave comes_back "kOff = tim1::kBreakEnable" "kOff = tim1::kBreakEnable | tim1::kAutomatic")
sc_optics_mutant(gate_wave floats "tim1::kOffIdle | " "")
sc_optics_mutant(gate_wave flag_stands "write32(tim1::kSr, ~tim1::kBreakFlag);" "")
sc_optics_mutant(gate_wave loaded_forgotten "kLoaded = 3" "kLoaded = 1")
sc_optics_mutant(gate_wave cancel_keeps_ring "segment.trigger = 0;" "")
sc_optics_mutant(gate_wave cancel_keeps_runs "segments_.drop();" "")
sc_optics_mutant(gate_wave no_darkness "put_stop(end);\n        barrier();" "barrier();")
sc_optics_mutant(gate_wave late_unseen "if (!runs_ || dry(before)) {" "if (!runs_) {")
sc_optics_mutant(gate_wave enabled_first "write32(kStream + dma::kPar, tim1::kDmar);"
  "write32(kStream + dma::kCr, kSettings | dma::kEnable);\n    write32(kStream + dma::kPar, tim1::kDmar);")
sc_optics_mutant(gate_wave not_circular "dma::kCircular | " "")
sc_optics_mutant(gate_wave burst_too_short "tim1::burst(tim1::kArr, kWords)" "tim1::burst(tim1::kArr, kWords - 1U)")
sc_optics_mutant(gate_wave blip_in_darkness "kNoCount - 1, 0xFFFF" "kNoCount, 0xFFFF")

sc_optics_mutant(safety_lines level_before_clear "write32(regs::kPending, moved);\n    const std::uint32_t open = ~read32(regs::kInputs) & kBoth;"
  "const std::uint32_t open = ~read32(regs::kInputs) & kBoth;\n    write32(regs::kPending, moved);")
sc_optics_mutant(safety_lines never_cleared "write32(regs::kPending, moved);" "")
sc_optics_mutant(safety_lines rising_alone "set_bits(regs::kFalling, kBoth);" "")
sc_optics_mutant(safety_lines unmasked_first "clear_bits(regs::kMask, kBoth);" "set_bits(regs::kMask, kBoth);")
sc_optics_mutant(safety_lines start_edge_stands "write32(regs::kPending, kBoth);" "")
sc_optics_mutant(safety_lines other_port "change_bits(regs::kPortOf8To11, 15U, regs::kPortE);" "")
sc_optics_mutant(safety_lines forgets_short_opening "opened_ |= open | moved;" "opened_ |= open;")
sc_optics_mutant(safety_lines period_flag_stands "write32(regs::kTim7Sr, ~regs::kUpdateFlag);" "")
sc_optics_mutant(safety_lines early_period "write32(regs::kTim7Sr, 0);" "")
sc_optics_mutant(safety_lines no_pull "2U << (2U * pin));  // down" "0);")
