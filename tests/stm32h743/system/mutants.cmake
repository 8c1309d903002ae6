# SPDX-License-Identifier: Apache-2.0
sc_h743_mutants(system LIBRARIES boards_stm32h743_system stm32h743_system_model
  PARTS clock_start watchdogs fault_record memory_start interrupts)

sc_h743_mutant(system clock_start no_wait_states "    if (!set_wait_states()) {
        return {ClockFault::wait_states, kSlow};
    }
    const ClockFault fault = speed_up();" "    const ClockFault fault = speed_up();
    (void)set_wait_states();")
sc_h743_mutant(system clock_start undivided "    set_dividers();\n" "")
sc_h743_mutant(system clock_start fast_before_dividers "    set_dividers();\n    clear_bits(rcc::kCr, rcc::kHsiDivider);"
  "    clear_bits(rcc::kCr, rcc::kHsiDivider);\n    set_dividers();")
sc_h743_mutant(system clock_start scale_unwaited "return wait_for(pwr::kD3cr, pwr::kScaleReady, true, kVoltageReads);\n}\n\nbool to_scale0"
  "return true;\n}\n\nbool to_scale0")
sc_h743_mutant(system clock_start overdrive_unwaited "    return wait_for(pwr::kD3cr, pwr::kScaleReady, true, kVoltageReads);\n}\n\nbool start_hse"
  "    return true;\n}\n\nbool start_hse")
sc_h743_mutant(system clock_start no_syscfg_clock "set_bits(rcc::kApb4enr, rcc::kSyscfgEn);" "")
sc_h743_mutant(system clock_start syscfg_clock_unsettled "(void)read32(rcc::kApb4enr);" "")
sc_h743_mutant(system clock_start supply_left_open "change_bits(pwr::kCr3, kAll, pwr::kLdoOn);" "")
sc_h743_mutant(system clock_start supply_unchecked "(read32(pwr::kCr3) & (pwr::kBypass | pwr::kLdoOn)) == pwr::kLdoOn &&" "")
sc_h743_mutant(system clock_start supply_unwaited "wait_for(pwr::kCsr1, pwr::kActualReady, true, kVoltageReads)" "true")
sc_h743_mutant(system clock_start no_bypass "set_bits(rcc::kCr, rcc::kHseBypass);" "")
sc_h743_mutant(system clock_start bypass_while_on "clear_bits(rcc::kCr, rcc::kHseOn);" "")
sc_h743_mutant(system clock_start hse_unwaited "return wait_for(rcc::kCr, rcc::kHseReady, true, kHseReads);" "return true;")
sc_h743_mutant(system clock_start pll_set_while_on "set_plls();\n    set_bits(rcc::kCr, rcc::kPll1On | rcc::kPll2On);"
  "set_bits(rcc::kCr, rcc::kPll1On | rcc::kPll2On);\n    set_plls();")
sc_h743_mutant(system clock_start pll_stop_unwaited "return wait_for(rcc::kCr, rcc::kPll1Ready | rcc::kPll2Ready, false, kSwitchReads);"
  "return true;")
sc_h743_mutant(system clock_start core_stays_on_pll "    if (!take(rcc::kFromHsi)) {\n        return false;\n    }" "")
sc_h743_mutant(system clock_start lock_unwaited "    if (!wait_for(rcc::kCr, rcc::kPll1Ready, true, kLockReads)) {
        return ClockFault::pll1;
    }" "")
sc_h743_mutant(system clock_start fdcan_before_lock "    set_bits(rcc::kCr, rcc::kPll1On | rcc::kPll2On);"
  "    set_bits(rcc::kCr, rcc::kPll1On | rcc::kPll2On);
    change_bits(rcc::kD2ccip1r, rcc::kFdcanSource, rcc::kFdcanFromPll2q);")
sc_h743_mutant(system clock_start wrong_range "kPll1.range() << 2U" "(kPll1.range() - 2U) << 2U")
sc_h743_mutant(system clock_start wrong_factor "(pll.n - 1)" "pll.n")
sc_h743_mutant(system clock_start unguarded "    set_bits(rcc::kCr, rcc::kHseGuard);\n" "")
sc_h743_mutant(system clock_start old_revision_too "< kFirstFastRevision" "< 0x1000U")
sc_h743_mutant(system clock_start switch_believed "    return becomes(rcc::kCfgr, rcc::kSwitchState, source << rcc::kSwitchStateShift, kSwitchReads);"
  "    return true;")
sc_h743_mutant(system clock_start plls_left_on "return {fall_back() ? fault : ClockFault::hsi, kSlow};" "return {fault, kSlow};")

sc_h743_mutant(system watchdogs not_unlocked "    write32(iwdg::kKr, iwdg::kUnlock);\n" "")
sc_h743_mutant(system watchdogs set_before_lsi "    write32(iwdg::kKr, iwdg::kStart);  // starts LSI as well, which the registers below need\n" "")
sc_h743_mutant(system watchdogs update_unwaited "!wait_for(iwdg::kSr, iwdg::kPrescalerBusy | iwdg::kReloadBusy, false, kUpdateReads)" "false")
sc_h743_mutant(system watchdogs long_first_time "    write32(iwdg::kKr, iwdg::kReload);\n    set_bits" "    set_bits")
sc_h743_mutant(system watchdogs resets_nothing "    set_bits(wwdg::kGcr, wwdg::kResetsSystem);\n" "")
sc_h743_mutant(system watchdogs no_clock "    set_bits(wwdg::kApb3enr, wwdg::kClock);\n" "")
sc_h743_mutant(system watchdogs clock_unsettled "    (void)read32(wwdg::kApb3enr);  // the clock is there two cycles later\n" "")
sc_h743_mutant(system watchdogs window_always_open "kOpen | wwdg::kWarning" "kFull | wwdg::kWarning")
sc_h743_mutant(system watchdogs no_warning "kOpen | wwdg::kWarning" "kOpen")
sc_h743_mutant(system watchdogs fault_feeds "gave_up_ = gave_up_ || !healthy;" "")
sc_h743_mutant(system watchdogs fault_is_forgotten "gave_up_ = gave_up_ || !healthy;" "gave_up_ = !healthy;")
sc_h743_mutant(system watchdogs window_alone "    write32(wwdg::kCr, wwdg::kActive | kFull);\n    write32(iwdg::kKr, iwdg::kReload);"
  "    write32(wwdg::kCr, wwdg::kActive | kFull);")
sc_h743_mutant(system watchdogs independent_alone "    write32(wwdg::kCr, wwdg::kActive | kFull);\n" "")
sc_h743_mutant(system watchdogs one_count_too_few "kLast + Watchdogs::kCounts - 1" "kLast + Watchdogs::kCounts - 5")
sc_h743_mutant(system watchdogs any_clock "frequencies.apb_hz != kFast.apb_hz" "frequencies.apb_hz == 0")
sc_h743_mutant(system watchdogs remembers_old_resets "    set_bits(rcc::kRsr, rcc::kForgetResets);\n" "")
sc_h743_mutant(system watchdogs warning_stands "{ write32(wwdg::kSr, 0); }" "{}")

sc_h743_mutant(system fault_record mode_first "    write32(port + regs::kBsrr, kPins << 16U);
    change_bits(port + regs::kModer, modes(kPins, 3), modes(kPins, 1));" "    change_bits(port + regs::kModer, modes(kPins, 3), modes(kPins, 1));
    write32(port + regs::kBsrr, kPins << 16U);")
sc_h743_mutant(system fault_record pins_stay_with_timer "    change_bits(port + regs::kModer, modes(kPins, 3), modes(kPins, 1));\n" "")
sc_h743_mutant(system fault_record no_port_clock "    set_bits(regs::kAhb4enr, regs::kGpioEClock | regs::kGpioFClock);\n" "")
sc_h743_mutant(system fault_record port_clock_unsettled "    set_bits(regs::kAhb4enr, regs::kGpioEClock | regs::kGpioFClock);
    (void)read32(regs::kAhb4enr);" "    set_bits(regs::kAhb4enr, regs::kGpioEClock | regs::kGpioFClock);")
sc_h743_mutant(system fault_record one_port_alone "    hold_low<kSafeLowF>(regs::kGpioF);\n" "")
sc_h743_mutant(system fault_record all_pins "write32(port + regs::kBsrr, kPins << 16U);" "write32(port + regs::kBsrr, 0xFFFF0000U);")
sc_h743_mutant(system fault_record main_output_stays "        clear_bits(regs::kTim1Bdtr, regs::kMainOutput);" "")
sc_h743_mutant(system fault_record timer_without_clock "if ((read32(regs::kApb2enr) & regs::kTim1Clock) != 0) {" "{")
sc_h743_mutant(system fault_record locked "    set_bits(regs::kPwrCr1, regs::kUnlockBackup);\n" "")
sc_h743_mutant(system fault_record no_ram_clock "    set_bits(regs::kAhb4enr, regs::kBackupRamClock);\n" "")
sc_h743_mutant(system fault_record unchecked "read32(kCheck) != check_of(words)" "read32(kCheck) == 0")
sc_h743_mutant(system fault_record no_check_word "    write32(kCheck, check_of(words));\n" "")
sc_h743_mutant(system fault_record last_word_lost "    write32(kCheck, check_of(words));
    // An ECC RAM may hold back its last write until the next one; a reset in between would lose it.
    write32(kFlush, 0);" "    write32(kCheck, check_of(words));")
sc_h743_mutant(system fault_record taken_twice "    write32(kCheck, 0);\n    write32(kFlush, 0);" "")
sc_h743_mutant(system fault_record addresses_believed "(record.cfsr & regs::kBfarValid) != 0 ?" "record.cfsr != 0 ?")
sc_h743_mutant(system fault_record any_stack "sp % 4 == 0 && sp >= memory::kDtcm.base && sp - memory::kDtcm.base <= memory::kDtcm.bytes - kFrameBytes" "sp != 0")
sc_h743_mutant(system fault_record stack_end_off "memory::kDtcm.bytes - kFrameBytes" "memory::kDtcm.bytes")
sc_h743_mutant(system fault_record zero_is_a_record "return hash | 1U;" "return words[0];")

sc_h743_mutant(system memory_start no_clocks "    set_bits(regs::kAhb2enr, regs::kSram1Clock | regs::kSram2Clock | regs::kSram3Clock);\n" "")
sc_h743_mutant(system memory_start clocks_unsettled "    (void)read32(regs::kAhb2enr);  // the clock is there two cycles later\n" "")
sc_h743_mutant(system memory_start set_while_on "    write32(regs::kMpuCtrl, 0);\n" "")
sc_h743_mutant(system memory_start old_regions_stay "            write32(regs::kMpuRasr, 0);\n" "")
sc_h743_mutant(system memory_start no_peripherals "regs::kMpuEnable | regs::kDefaultMap" "regs::kMpuEnable")
sc_h743_mutant(system memory_start half_as_large "std::bit_width(one.range.bytes)) - 2)" "std::bit_width(one.range.bytes)) - 3)")
sc_h743_mutant(system memory_start dma_is_cached "not_cached: word |= regs::kTypeExtension1;"
  "not_cached: word |= regs::kTypeExtension1 | regs::kCacheable | regs::kBufferable;")
sc_h743_mutant(system memory_start everything_executes "one.execute ? 0U : regs::kNeverExecute" "0U")
sc_h743_mutant(system memory_start code_is_writable "word |= regs::kReadOnly;" "word |= regs::kReadWrite;")
sc_h743_mutant(system memory_start caches_before_protection "    if (!protect(bank)) {
        return false;
    }
    start_data_cache();" "    start_data_cache();
    if (!protect(bank)) {
        return false;
    }")
sc_h743_mutant(system memory_start half_invalidated "way < regs::kDataCacheWays" "way < 2")
sc_h743_mutant(system memory_start invalidated_while_on "    if ((read32(regs::kCcr) & regs::kDataCache) != 0) {
        return;
    }\n" "")
sc_h743_mutant(system memory_start old_code_stays "    write32(regs::kIciallu, 0);\n" "")
sc_h743_mutant(system memory_start too_few_regions_pass "regions < plan.size()" "regions == 0")
sc_h743_mutant(system memory_start no_division_trap "    set_bits(regs::kCcr, regs::kDivisionTrap);\n" "")
sc_h743_mutant(system memory_start wrong_bank "const auto plan = protection(bank);" "const auto plan = protection(3 - bank);")

sc_h743_mutant(system interrupts old_ones_stay_on "        write32(nvic::kIcer + 4 * i, ~0U);\n" "")
sc_h743_mutant(system interrupts old_ones_stay_pending "        write32(nvic::kIcpr + 4 * i, ~0U);\n" "")
sc_h743_mutant(system interrupts few_words "i < nvic::kWords" "i < 2")
sc_h743_mutant(system interrupts no_key "nvic::kKey | nvic::kAllPreempt" "nvic::kAllPreempt")
sc_h743_mutant(system interrupts nobody_breaks_in "nvic::kKey | nvic::kAllPreempt" "nvic::kKey | nvic::kGroups")
sc_h743_mutant(system interrupts unshifted "one.priority << nvic::kPriorityShift" "one.priority")
sc_h743_mutant(system interrupts servo_breaks_in "            write8(nvic::kPendSvPriority, byte);\n" "")
sc_h743_mutant(system interrupts warning_has_no_priority "    write8(nvic::kIpr, 0);  // the watchdog's warning\n" "")
sc_h743_mutant(system interrupts faults_wait "    write32(nvic::kFaultPriorities, 0);\n" "")
sc_h743_mutant(system interrupts pending_from_before "    write32(nvic::kIcpr + word, bit);  // what came before the driver was ready\n" "")
sc_h743_mutant(system interrupts anything_goes "number < 0 || !known" "number < 0 || number >= 150")
sc_h743_mutant(system interrupts wrong_word "4 * (number / 32)" "number / 32")
