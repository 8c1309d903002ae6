# SPDX-License-Identifier: Apache-2.0
# Ablation of the store: one rule is taken out of a copy of a source, and its tests must fail.
# `part`: of whose source and tests.
foreach(part backup_ram flash_memory flash_store flash_parameters slots)
  add_library(stm32h743_${part}_tests OBJECT "${CMAKE_CURRENT_LIST_DIR}/${part}_test.cpp")
  target_link_libraries(stm32h743_${part}_tests PRIVATE sc_warnings sc_sanitizers boards_stm32h743_store
    stm32h743_store_model firmware_store GTest::gtest)
endforeach()

function(sc_store_mutant part name from to)
  set(source "${PROJECT_SOURCE_DIR}/boards/stm32h743/store/${part}.cpp")
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${source}")
  file(READ "${source}" text)
  string(REPLACE "${from}" "${to}" mutant "${text}")
  if(mutant STREQUAL text)
    message(FATAL_ERROR "${part} mutant ${name}: there is no '${from}' to take out")
  endif()
  set(out "${PROJECT_BINARY_DIR}/${part}_mutants/${name}.cpp")
  file(CONFIGURE OUTPUT "${out}" CONTENT "${mutant}" @ONLY)
  add_executable(${part}_mutant_${name} $<TARGET_OBJECTS:stm32h743_${part}_tests> "${out}")
  target_link_libraries(${part}_mutant_${name} PRIVATE sc_warnings sc_sanitizers boards_stm32h743_store
    stm32h743_store_model firmware_store GTest::gtest GTest::gtest_main)
  set_target_properties(${part}_mutant_${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/tests")
  add_test(NAME unit.${part}_mutant_${name} COMMAND ${part}_mutant_${name} --gtest_brief=1)
  set_tests_properties(unit.${part}_mutant_${name} PROPERTIES LABELS unit WILL_FAIL TRUE TIMEOUT 60)
endfunction()

sc_store_mutant(flash_memory no_second_key "        write32(regs::kKeyr + bank, regs::kSecondKey);\n" "")
sc_store_mutant(flash_memory keys_again "if ((read32(regs::kCr + bank) & regs::kLock) != 0) {" "{")
sc_store_mutant(flash_memory flags_stand "    write32(regs::kCcr + bank, kErrors);\n" "")
sc_store_mutant(flash_memory start_at_once "    write32(regs::kCr + bank, which);\n" "")
sc_store_mutant(flash_memory no_program_bit "regs::kProgram | regs::kSize64" "regs::kSize64")
sc_store_mutant(flash_memory too_fast "const bool at_work = (flags & kAtWork) != 0" "const bool at_work = (flags & regs::kBufferNotEmpty) != 0")
sc_store_mutant(flash_memory twice "read_now == Read::lost || !erased(there)" "read_now == Read::lost")
sc_store_mutant(flash_memory cache_stands "    write32(regs::kDcimvac, at);\n" "")
sc_store_mutant(flash_memory no_guard "        const FaultGuard guard;\n" "")
sc_store_mutant(flash_memory lost_flag_stands "write32(regs::kCcr + bank, regs::kDoubleError" "write32(regs::kCcr + bank, (regs::kDoubleError & 0U)")
sc_store_mutant(flash_memory reads_while_working "    if ((read32(regs::kSr + bank) & kAtWork) != 0) {\n        return Read::away;\n    }\n" "")
sc_store_mutant(flash_memory writes_while_marking "if (marking_) {" "if (failure_ == 1) {")
sc_store_mutant(flash_memory not_read_back "&& !reads_back()" "&& failure_ == 1 && !reads_back()")
sc_store_mutant(flash_memory not_locked_after "    write32(regs::kCr + bank_, regs::kLock);\n" "")
sc_store_mutant(flash_memory no_limit "if (now_ms - since_ms_ <=" "if (now_ms - now_ms <=")
sc_store_mutant(flash_memory other_bank "? 0 : regs::kBank2" "? regs::kBank2 : 0")

sc_store_mutant(flash_store in_place "phase_ == Phase::append ? active_ : 1 - active_;" "active_;")
sc_store_mutant(flash_store no_erase "room() ? Phase::append : Phase::erase" "room() ? Phase::append : Phase::seal")
sc_store_mutant(flash_store no_copy "        copy_key_ = 0;\n" "        copy_key_ = kKeys;\n")
sc_store_mutant(flash_store head_first "        slot_ = 1;\n        next_copy();" "        slot_ = 1;\n        active_ = 1 - active_;\n        next_copy();")
sc_store_mutant(flash_store older_sector "generations[1] >= generations[0]" "generations[1] < generations[0]")
sc_store_mutant(flash_store generation_stays "put(generation_ + 1)" "put(generation_)")
sc_store_mutant(flash_store unchecked "crc != of.value()" "crc == 0")
sc_store_mutant(flash_store not_left_out "next_ = last_ + 2" "next_ = last_ + 1")
sc_store_mutant(flash_store ends_at_a_gap "slot - last_ <= kMostBlank" "slot - last_ <= 1")
sc_store_mutant(flash_store same_slot_again "        ++slot_;\n        return Progress::working;" "        return Progress::working;")
sc_store_mutant(flash_store first_counts "        at_[head.key] = static_cast<std::uint16_t>(slot);"
  "        at_[head.key] = at_[head.key] != 0 ? at_[head.key] : static_cast<std::uint16_t>(slot);")
sc_store_mutant(flash_store drop_forgotten "head.kind == Kind::drop" "head.kind == Kind::drop && slot == 0")
sc_store_mutant(flash_store marking_fails "return Progress::put_off" "return failed()")
sc_store_mutant(flash_store half_a_record "if (well && ++word_ < writing_.size()) {" "if (well && ++word_ < 1) {")
sc_store_mutant(flash_store steals_work "        return Progress::working;  // for somebody else"
  "        (void)flash_->step(0);")

sc_store_mutant(flash_parameters copy_before_flash "    if (!ended(progress)) {" "    if (!ended(progress) && now_ms == 0) {")
sc_store_mutant(flash_parameters failed_is_done "if (progress == FlashStore::Progress::done) {\n        in_flash_"
  "if (ended(progress)) {\n        in_flash_")
sc_store_mutant(flash_parameters marks_at_once "    in_flash_ = true;\n" "")
sc_store_mutant(flash_parameters flash_before_backup "if (!record && fired.record())" "if (fired.record())")
sc_store_mutant(flash_parameters not_written_back "        retained.write(*record);\n" "")
sc_store_mutant(flash_parameters same_number "return false;\n    }\n    wanted_ = record;" "return false;\n    }\n    wanted_ = JobRecord{};")
sc_store_mutant(flash_parameters whole_erased "store_->drop(slot * kUnits, kUnits)" "store_->drop(0, kKeysUsed)")

sc_store_mutant(backup_ram no_clock "    set_bits(regs::kAhb4enr, regs::kRamClock);\n" "")
sc_store_mutant(backup_ram regulator_first "    set_bits(regs::kPwrCr1, regs::kAccess);\n"
  "    set_bits(regs::kPwrCr2, regs::kRegulator);\n    set_bits(regs::kPwrCr1, regs::kAccess);\n")
sc_store_mutant(backup_ram no_regulator "    set_bits(regs::kPwrCr2, regs::kRegulator);\n" "")
sc_store_mutant(backup_ram not_waited "if (!wait_for(regs::kPwrCr2, regs::kRegulatorReady, true, kReadsForRegulator)) {"
  "if (kReadsForRegulator == 0) {")
sc_store_mutant(backup_ram no_guard "    const FaultGuard guard;\n    (void)read32(at);\n"
  "    (void)read32(at);\n    const FaultGuard guard;\n")
sc_store_mutant(backup_ram lost_words_stay "            write32(at, 0);\n" "")
sc_store_mutant(backup_ram half_the_ram "kBackupRam + kBackupRamBytes; at" "kBackupRam + kRetainedBytes; at")

sc_store_mutant(slots trial_without_end "static_cast<std::uint8_t>(starts + 1)" "starts")
sc_store_mutant(slots starts_what_is_not_whole "next.state[index(one)] == state && verified[index(one)]"
  "next.state[index(one)] == state")
sc_store_mutant(slots tries_what_is_not_whole "!verified[index(one)] || starts >= kTrialStarts" "starts >= kTrialStarts")
sc_store_mutant(slots older_starts "{next.newest, other(next.newest)}) {" "{other(next.newest), next.newest}) {")
sc_store_mutant(slots not_counted_first "if (record != next && (record || slot)) {" "if (!record && slot) {")
sc_store_mutant(slots uncounted_trial "progress == Progress::failed && on_trial_" "progress == Progress::idle && on_trial_")
sc_store_mutant(slots writes_where_it_runs "    updating_ = other(running);" "    updating_ = running;")
sc_store_mutant(slots update_from_a_trial "!= SlotState::confirmed) {\n        return Refusal::not_ready"
  "== SlotState::bad) {\n        return Refusal::not_ready")
sc_store_mutant(slots written_at_once "= SlotState::empty;\n    next.newest = running;"
  "= SlotState::written;\n    next.newest = running;")
sc_store_mutant(slots erased_in_part "++erased_ == flash_layout::kSlotSectors" "++erased_ == flash_layout::kSlotSectors - 1")
sc_store_mutant(slots unverified "!updating_ || !verified" "!updating_ || (!verified && next_word_ == 0)")
sc_store_mutant(slots confirms_the_older "    next.state[index(running)] = SlotState::confirmed;\n    next.newest = running;"
  "    next.state[index(running)] = SlotState::confirmed;")
sc_store_mutant(slots kept_before_written "    wanted_ = record;\n" "    wanted_ = record;\n    record_ = record;\n")
sc_store_mutant(slots invalid_not_first "    if (phase_ == Phase::invalidate && progress == Progress::done) {"
  "    if (phase_ == Phase::invalidate) {")
sc_store_mutant(slots while_marking "    if (flash_->marking()) {" "    if (flash_->working()) {")
