# SPDX-License-Identifier: Apache-2.0
sc_h743_mutants(store LIBRARIES boards_stm32h743_store stm32h743_store_model firmware_store
  PARTS backup_ram flash_memory flash_store flash_parameters slots)

sc_h743_mutant(store flash_memory no_second_key "        write32(regs::kKeyr + bank, regs::kSecondKey);\n" "")
sc_h743_mutant(store flash_memory keys_again "if ((read32(regs::kCr + bank) & regs::kLock) != 0) {" "{")
sc_h743_mutant(store flash_memory flags_stand "    write32(regs::kCcr + bank, kErrors);\n" "")
sc_h743_mutant(store flash_memory start_at_once "    write32(regs::kCr + bank, which);\n" "")
sc_h743_mutant(store flash_memory no_program_bit "regs::kProgram | regs::kSize64" "regs::kSize64")
sc_h743_mutant(store flash_memory too_fast "const bool at_work = (flags & kAtWork) != 0" "const bool at_work = (flags & regs::kBufferNotEmpty) != 0")
sc_h743_mutant(store flash_memory twice "read_now == Read::lost || !erased(there)" "read_now == Read::lost")
sc_h743_mutant(store flash_memory cache_stands "    write32(regs::kDcimvac, at);\n" "")
sc_h743_mutant(store flash_memory no_guard "        const FaultGuard guard;\n" "")
sc_h743_mutant(store flash_memory lost_flag_stands "write32(regs::kCcr + bank, regs::kDoubleError" "write32(regs::kCcr + bank, (regs::kDoubleError & 0U)")
sc_h743_mutant(store flash_memory reads_while_working "    if ((read32(regs::kSr + bank) & kAtWork) != 0) {\n        return Read::away;\n    }\n" "")
sc_h743_mutant(store flash_memory writes_while_marking "if (marking_) {" "if (failure_ == 1) {")
sc_h743_mutant(store flash_memory not_read_back "&& !reads_back()" "&& failure_ == 1 && !reads_back()")
sc_h743_mutant(store flash_memory not_locked_after "    write32(regs::kCr + bank_, regs::kLock);\n" "")
sc_h743_mutant(store flash_memory no_limit "if (now_ms - since_ms_ <=" "if (now_ms - now_ms <=")
sc_h743_mutant(store flash_memory other_bank "? 0 : regs::kBank2" "? regs::kBank2 : 0")

sc_h743_mutant(store flash_store in_place "phase_ == Phase::append ? active_ : 1 - active_;" "active_;")
sc_h743_mutant(store flash_store no_erase "room() ? Phase::append : Phase::erase" "room() ? Phase::append : Phase::seal")
sc_h743_mutant(store flash_store no_copy "        copy_key_ = 0;\n" "        copy_key_ = kKeys;\n")
sc_h743_mutant(store flash_store head_first "        slot_ = 1;\n        next_copy();" "        slot_ = 1;\n        active_ = 1 - active_;\n        next_copy();")
sc_h743_mutant(store flash_store older_sector "generations[1] >= generations[0]" "generations[1] < generations[0]")
sc_h743_mutant(store flash_store generation_stays "put(generation_ + 1)" "put(generation_)")
sc_h743_mutant(store flash_store unchecked "crc != of.value()" "crc == 0")
sc_h743_mutant(store flash_store not_left_out "next_ = last_ + 2" "next_ = last_ + 1")
sc_h743_mutant(store flash_store ends_at_a_gap "slot - last_ <= kMostBlank" "slot - last_ <= 1")
sc_h743_mutant(store flash_store same_slot_again "        ++slot_;\n        return Progress::working;" "        return Progress::working;")
sc_h743_mutant(store flash_store first_counts "        at_[head.key] = static_cast<std::uint16_t>(slot);"
  "        at_[head.key] = at_[head.key] != 0 ? at_[head.key] : static_cast<std::uint16_t>(slot);")
sc_h743_mutant(store flash_store drop_forgotten "head.kind == Kind::drop" "head.kind == Kind::drop && slot == 0")
sc_h743_mutant(store flash_store marking_fails "return Progress::put_off" "return failed()")
sc_h743_mutant(store flash_store half_a_record "if (well && ++word_ < writing_.size()) {" "if (well && ++word_ < 1) {")
sc_h743_mutant(store flash_store steals_work "        return Progress::working;  // for somebody else"
  "        (void)flash_->step(0);")

sc_h743_mutant(store flash_parameters copy_before_flash "    if (!ended(progress)) {" "    if (!ended(progress) && now_ms == 0) {")
sc_h743_mutant(store flash_parameters failed_is_done "if (progress == FlashStore::Progress::done) {\n        in_flash_"
  "if (ended(progress)) {\n        in_flash_")
sc_h743_mutant(store flash_parameters marks_at_once "    in_flash_ = true;\n" "")
sc_h743_mutant(store flash_parameters flash_before_backup "if (!record && fired.record())" "if (fired.record())")
sc_h743_mutant(store flash_parameters not_written_back "        retained.write(*record);\n" "")
sc_h743_mutant(store flash_parameters same_number "return false;\n    }\n    wanted_ = record;" "return false;\n    }\n    wanted_ = JobRecord{};")
sc_h743_mutant(store flash_parameters whole_erased "store_->drop(slot * kUnits, kUnits)" "store_->drop(0, kKeysUsed)")

sc_h743_mutant(store backup_ram no_clock "    set_bits(regs::kAhb4enr, regs::kRamClock);\n" "")
sc_h743_mutant(store backup_ram regulator_first "    set_bits(regs::kPwrCr1, regs::kAccess);\n"
  "    set_bits(regs::kPwrCr2, regs::kRegulator);\n    set_bits(regs::kPwrCr1, regs::kAccess);\n")
sc_h743_mutant(store backup_ram no_regulator "    set_bits(regs::kPwrCr2, regs::kRegulator);\n" "")
sc_h743_mutant(store backup_ram not_waited "if (!wait_for(regs::kPwrCr2, regs::kRegulatorReady, true, kReadsForRegulator)) {"
  "if (kReadsForRegulator == 0) {")
sc_h743_mutant(store backup_ram no_guard "    const FaultGuard guard;\n    (void)read32(at);\n"
  "    (void)read32(at);\n    const FaultGuard guard;\n")
sc_h743_mutant(store backup_ram lost_words_stay "            write32(at, 0);\n" "")
sc_h743_mutant(store backup_ram half_the_ram "kBackupRam + kBackupRamBytes; at" "kBackupRam + kRetainedBytes; at")

sc_h743_mutant(store slots trial_without_end "static_cast<std::uint8_t>(starts + 1)" "starts")
sc_h743_mutant(store slots starts_what_is_not_whole "next.state[index(one)] == state && verified[index(one)]"
  "next.state[index(one)] == state")
sc_h743_mutant(store slots tries_what_is_not_whole "!verified[index(one)] || starts >= kTrialStarts" "starts >= kTrialStarts")
sc_h743_mutant(store slots older_starts "{next.newest, other(next.newest)}) {" "{other(next.newest), next.newest}) {")
sc_h743_mutant(store slots not_counted_first "if (record != next && (record || slot)) {" "if (!record && slot) {")
sc_h743_mutant(store slots uncounted_trial "progress == Progress::failed && on_trial_" "progress == Progress::idle && on_trial_")
sc_h743_mutant(store slots writes_where_it_runs "    updating_ = other(running);" "    updating_ = running;")
sc_h743_mutant(store slots update_from_a_trial "!= SlotState::confirmed) {\n        return Refusal::not_ready"
  "== SlotState::bad) {\n        return Refusal::not_ready")
sc_h743_mutant(store slots written_at_once "= SlotState::empty;\n    next.newest = running;"
  "= SlotState::written;\n    next.newest = running;")
sc_h743_mutant(store slots erased_in_part "++erased_ == flash_layout::kSlotSectors" "++erased_ == flash_layout::kSlotSectors - 1")
sc_h743_mutant(store slots unverified "!updating_ || !verified" "!updating_ || (!verified && next_word_ == 0)")
sc_h743_mutant(store slots confirms_the_older "    next.state[index(running)] = SlotState::confirmed;\n    next.newest = running;"
  "    next.state[index(running)] = SlotState::confirmed;")
sc_h743_mutant(store slots kept_before_written "    wanted_ = record;\n" "    wanted_ = record;\n    record_ = record;\n")
sc_h743_mutant(store slots invalid_not_first "    if (phase_ == Phase::invalidate && progress == Progress::done) {"
  "    if (phase_ == Phase::invalidate) {")
sc_h743_mutant(store slots while_marking "    if (flash_->marking()) {" "    if (flash_->working()) {")
