# SPDX-License-Identifier: Apache-2.0
sc_test(stm32h743_io LABEL unit SOURCES ${CMAKE_CURRENT_LIST_DIR}/digital_port_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/control_clock_test.cpp ${CMAKE_CURRENT_LIST_DIR}/registers_test.cpp
  DEPS boards_stm32h743_io stm32h743_optics_model)
sc_h743_mutants(io LIBRARIES boards_stm32h743_io stm32h743_optics_model PARTS digital_port control_clock)
sc_h743_mutant(io digital_port out_before_low "    make_safe();\n    clear_bits" "    clear_bits")
sc_h743_mutant(io digital_port floats "    change_bits(port + gpio::kPupdr, pairs(pins, 3), pairs(pins, gpio::kPullDown));\n" "")
sc_h743_mutant(io digital_port no_clock "    set_bits(gpio::kAhb4enr, gpio::clock(gpio::Port::d) |" "    set_bits(gpio::kAhb4enr,")
sc_h743_mutant(io digital_port sets_alone "on | (kOutPins & ~on) << 16U" "on")
sc_h743_mutant(io digital_port source_shifted "& kSourcePins)" "& kSourcePins & 7U)")
sc_h743_mutant(io control_clock not_from_zero "write32(tim5::kEgr, tim5::kGenerateUpdate);" "")
sc_h743_mutant(io control_clock short_period "write32(tim5::kArr, 0xFFFFFFFFU);" "")
sc_h743_mutant(io control_clock origin_lost "(tick - origin_ms_)" "(tick)")
sc_h743_mutant(io control_clock no_sign "static_cast<std::int32_t>(read32(tim5::kCnt) - begin)" "(read32(tim5::kCnt) - begin)")
sc_h743_mutant(io control_clock stands_unseen "read32(tim5::kCnt) != first" "read32(tim5::kCnt) == first")
