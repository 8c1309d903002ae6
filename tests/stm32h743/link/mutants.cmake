# SPDX-License-Identifier: Apache-2.0
# Ablation of the ports: one rule is taken out of a copy of the driver, and its tests must fail.
foreach(part fdcan host_uart sensor_port)
  add_library(stm32h743_${part}_tests OBJECT "${CMAKE_CURRENT_LIST_DIR}/${part}_test.cpp")
  target_link_libraries(stm32h743_${part}_tests PRIVATE sc_warnings sc_sanitizers boards_stm32h743_link
    stm32h743_link_model firmware_sensors GTest::gtest)
endforeach()

# part: of whose driver and tests; name: of the mutant; from, to: texts.
function(sc_link_mutant part name from to)
  set(source "${PROJECT_SOURCE_DIR}/boards/stm32h743/link/${part}.cpp")
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${source}")
  file(READ "${source}" text)
  string(REPLACE "${from}" "${to}" mutant "${text}")
  if(mutant STREQUAL text)
    message(FATAL_ERROR "${part} mutant ${name}: there is no '${from}' to take out")
  endif()
  set(out "${PROJECT_BINARY_DIR}/${part}_mutants/${name}.cpp")
  file(CONFIGURE OUTPUT "${out}" CONTENT "${mutant}" @ONLY)
  # Objects of the program itself come before those of the library.
  add_executable(${part}_mutant_${name} $<TARGET_OBJECTS:stm32h743_${part}_tests> "${out}")
  target_link_libraries(${part}_mutant_${name} PRIVATE sc_warnings sc_sanitizers boards_stm32h743_link
    stm32h743_link_model firmware_sensors GTest::gtest GTest::gtest_main)
  # What a rule was for may be unused without it.
  set_source_files_properties("${out}" PROPERTIES COMPILE_OPTIONS -Wno-unused)
  set_target_properties(${part}_mutant_${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/tests")
  add_test(NAME unit.${part}_mutant_${name} COMMAND ${part}_mutant_${name} --gtest_brief=1)
  set_tests_properties(unit.${part}_mutant_${name} PROPERTIES LABELS unit WILL_FAIL TRUE TIMEOUT 60)
endfunction()

sc_link_mutant(fdcan init_not_awaited "!wait_for(at(kCccr), kInit, true, kReads)" "kReads == 0")
sc_link_mutant(fdcan not_opened "set_bits(at(kCccr), kChangeEnable);\n    if" "if")
sc_link_mutant(fdcan left_in_init "clear_bits(at(kCccr), kInit);\n    if (!wait_for(at(kCccr), kInit, false, kReads))"
  "if (kReads == 0)")
sc_link_mutant(fdcan no_clock "set_bits(kApb1henr, kClock);" "")
sc_link_mutant(fdcan asked_before_written "write32(element, frame.extended"
  "write32(at(kTxbar), 1U << index);\n    write32(element, frame.extended")
sc_link_mutant(fdcan acknowledged_before_read "const std::uint32_t first = read32(element);"
  "write32(at(kRxf0a), index);\n    const std::uint32_t first = read32(element);")
sc_link_mutant(fdcan never_acknowledged "write32(at(kRxf0a), index);" "")
sc_link_mutant(fdcan no_delay_compensation "kDelayCompensation | (fast" "(fast")
sc_link_mutant(fdcan no_second_sample "(fast.prescaler * (1 + fast.before)) << 8U" "0")
sc_link_mutant(fdcan stamps_by_two_rates "settings_.fd ? 0U : kStampByBits" "kStampByBits")
sc_link_mutant(fdcan parts_overlap "kTxFifoSizeAt | settings_.tx_ram()" "kTxFifoSizeAt | settings_.ram")
sc_link_mutant(fdcan short_elements "write32(at(kRxesc), settings_.fd ? kData64 : 0U);" "write32(at(kRxesc), 0);")
sc_link_mutant(fdcan first_element_always "(status & kPutIndex) >> kPutIndexAt" "(status & kPutIndex) >> 31U")
sc_link_mutant(fdcan full_unseen "(status & kTxFull) != 0" "status == 0")
sc_link_mutant(fdcan lost_unseen "(flags & kLostInFifo0) != 0" "flags == kAllInterrupts")
sc_link_mutant(fdcan lost_told_twice "write32(at(kIr), lost);" "")
sc_link_mutant(fdcan interrupt_stands "write32(at(kIr), flags);" "")
sc_link_mutant(fdcan back_at_once "now_ns - off_since_ns_ >= kBusOffNs" "now_ns >= off_since_ns_")
sc_link_mutant(fdcan never_back "stopped && now_ns - off_since_ns_ >= kBusOffNs" "stopped && now_ns < off_since_ns_")
sc_link_mutant(fdcan stale_frames_leave "set_bits(at(kCccr), kChangeEnable);\n    clear_bits" "clear_bits")
sc_link_mutant(fdcan active_too_soon "recovering_ = recovering_ && (status & kBusOff) != 0;" "recovering_ = false;")
sc_link_mutant(fdcan narrow_identifiers "frame.id << kStandardAt" "frame.id")

sc_link_mutant(host_uart no_dma_clock "set_bits(usart::kAhb1enr, usart::kDma1Clock);" "")
sc_link_mutant(host_uart stop_not_awaited "!wait_for(kInDma + dma::kCr, dma::kEnable, false, kReads)" "kReads == 0")
sc_link_mutant(host_uart flags_of_before "write32(dma::kLifcr, dma::kAllFlags << kOutFlagsAt);" "")
sc_link_mutant(host_uart may_lock "dma::kCircular | usart::kBufferable" "dma::kCircular")
sc_link_mutant(host_uart not_circular "dma::kMemoryIncrement | dma::kCircular | " "dma::kMemoryIncrement | ")
sc_link_mutant(host_uart enabled_first "write32(kInDma + dma::kPar, kUart + usart::kRdr);"
  "write32(kInDma + dma::kCr, kInSettings | dma::kEnable);\n    write32(kInDma + dma::kPar, kUart + usart::kRdr);")
sc_link_mutant(host_uart on_before_rate "write32(kUart + usart::kBrr,"
  "write32(kUart + usart::kCr1, usart::kEnable);\n    write32(kUart + usart::kBrr,")
sc_link_mutant(host_uart not_turned_off "write32(kUart + usart::kCr1, 0);" "")
sc_link_mutant(host_uart running_buffer "(read32(kOutDma + dma::kCr) & dma::kEnable) != 0" "kReads == 0")
sc_link_mutant(host_uart same_buffer "filling_ = 1 - filling_;" "")
sc_link_mutant(host_uart lap_unseen "if (place >= read_) {" "if (place > kIn) {")
sc_link_mutant(host_uart lap_flag_stands "write32(dma::kLifcr, dma::kComplete << kInFlagsAt);" "")
sc_link_mutant(host_uart place_read_once "if (again >= place) {" "if (again < kIn) {")
sc_link_mutant(host_uart wrap_forgotten "read_ = (read_ + 1) % kIn;" "read_ = read_ + 1 < kIn ? read_ + 1 : place;")
sc_link_mutant(host_uart errors_stand "write32(kUart + usart::kIcr, flags);" "")
sc_link_mutant(host_uart fault_ends_it "read_ = 0;\n            begin_receiving();" "")
sc_link_mutant(host_uart idle_stands "write32(kUart + usart::kIcr, usart::kIdle);\n    return idle;" "return idle;")
sc_link_mutant(host_uart start_unproved "!wait_for(kUart + usart::kIsr, usart::kTransmitReady | usart::kReceiveReady, true, kReads)"
  "kReads == 0")

sc_link_mutant(sensor_port driver_stays_off "write32(at(usart::kCr3), usart::kDriverEnable);" "")
sc_link_mutant(sensor_port echo_heard "clear_bits(at(usart::kCr1), usart::kReceive);" "")
sc_link_mutant(sensor_port deaf_after_sending "(control & ~usart::kCompleteInterrupt) | usart::kReceive)"
  "(control & ~usart::kCompleteInterrupt))")
sc_link_mutant(sensor_port hears_its_last_byte "(control & ~usart::kEmptyInterrupt) | usart::kCompleteInterrupt)"
  "(control & ~usart::kEmptyInterrupt) | usart::kCompleteInterrupt | usart::kReceive)")
sc_link_mutant(sensor_port empty_stands "(control & ~usart::kEmptyInterrupt) | usart::kCompleteInterrupt"
  "control | usart::kCompleteInterrupt")
sc_link_mutant(sensor_port overwrites "if ((flags & usart::kEmpty) != 0) {" "if (flags != 0) {\n            write32(at(usart::kTdr), 0);")
sc_link_mutant(sensor_port settings_while_on "clear_bits(at(usart::kCr1), usart::kEnable);" "")
sc_link_mutant(sensor_port parity_of_eight "usart::kParity | usart::kNineBits" "usart::kParity")
sc_link_mutant(sensor_port no_timeout "write32(at(usart::kCr2), usart::kTimeoutEnable);" "write32(at(usart::kCr2), 0);")
sc_link_mutant(sensor_port timeout_stands "write32(at(usart::kIcr), usart::kTimeout);" "")
sc_link_mutant(sensor_port silence_too_short "(even ? 77U : 70U) / 2" "(even ? 77U : 70U) / 4")
sc_link_mutant(sensor_port errors_stand "write32(at(usart::kIcr), flags & kErrors);" "")
sc_link_mutant(sensor_port gap_forgotten "(gap_ ? kGapFlag : 0U)" "0U")
sc_link_mutant(sensor_port too_soon "now_ns < due_ns_ - lead_ns_" "now_ns < due_ns_ - 1'000'000")
sc_link_mutant(sensor_port lead_forgotten "kAssert << usart::kAssertAt" "0U << usart::kAssertAt")
sc_link_mutant(sensor_port request_overwritten "state_ != State::hearing || " "")
sc_link_mutant(sensor_port future_bytes "queue_[first_].end_ns <= tick_ns" "kReads != 0")
sc_link_mutant(sensor_port collision_unseen "++counters_.cut;" "")
