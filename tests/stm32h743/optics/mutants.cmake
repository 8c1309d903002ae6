# SPDX-License-Identifier: Apache-2.0
sc_h743_mutants(optics boards_stm32h743_optics stm32h743_optics_model galvo_wave gate_wave safety_lines)

sc_h743_mutant(optics galvo_wave swap_unchecked "held != Next::open;\n}" "true;\n}")
sc_h743_mutant(optics galvo_wave never_repeats "words <= kDeadlineWords" "words == 0")
sc_h743_mutant(optics galvo_wave address_in_play "const unsigned coming = 1 - playing()" "const unsigned coming = playing()")
sc_h743_mutant(optics galvo_wave enabled_first "write32(kStream + dma::kPar, optics_port::kBsrr);"
  "write32(kStream + dma::kCr, kSettings | dma::kEnable);\n    write32(kStream + dma::kPar, optics_port::kBsrr);")
sc_h743_mutant(optics galvo_wave flags_stand "write32(dma::kLifcr, dma::kAllFlags);" "")
sc_h743_mutant(optics galvo_wave asks_before_update "write32(tim6::kEgr, tim6::kGenerateUpdate);"
  "write32(tim6::kDier, tim6::kUpdateDma);\n    write32(tim6::kEgr, tim6::kGenerateUpdate);")
sc_h743_mutant(optics galvo_wave sync_high "left == 1 ? rise ^ kSyncLow : rise" "(left > kGalvoBits) ? rise ^ kSyncLow : rise")
sc_h743_mutant(optics galvo_wave last_bit_first "(words.x >> (left - 1))" "(words.x >> (kGalvoBits - left))")
sc_h743_mutant(optics galvo_wave gate_stays_open "shut_ = true;\n        ++underruns_" "++underruns_")

sc_h743_mutant(optics gate_wave compare_at_once "tim1::first_mode(tim1::kCombinedPwm1) | tim1::kFirstPreload |"
  "tim1::first_mode(tim1::kCombinedPwm1) |")
sc_h743_mutant(optics gate_wave reload_at_once "write32(tim1::kCr1, tim1::kCounterEnable | tim1::kReloadPreload);"
  "write32(tim1::kCr1, tim1::kCounterEnable);")
sc_h743_mutant(optics gate_wave no_first_update "write32(tim1::kEgr, tim1::kGenerateUpdate);" "")
sc_h743_mutant(optics gate_wave repeats_off_by_one "segment.repeats)" "segment.repeats + 1U)")
sc_h743_mutant(optics gate_wave asks_before_update "write32(tim1::kEgr, tim1::kGenerateUpdate);"
  "write32(tim1::kDier, tim1::kUpdateDma);\n    write32(tim1::kEgr, tim1::kGenerateUpdate);")
sc_h743_mutant(optics gate_wave no_break "kOff = tim1::kBreakEnable | " "kOff = ")
sc_h743_mutant(optics gate_wave break_high "kOff = tim1::kBreakEnable" "kOff = tim1::kBreakEnable | tim1::kBreakHigh")
sc_h743_mutant(optics gate_wave comes_back "kOff = tim1::kBreakEnable" "kOff = tim1::kBreakEnable | tim1::kAutomatic")
sc_h743_mutant(optics gate_wave floats "tim1::kOffIdle | " "")
sc_h743_mutant(optics gate_wave flag_stands "write32(tim1::kSr, ~tim1::kBreakFlag);" "")
sc_h743_mutant(optics gate_wave loaded_forgotten "kLoaded = 3" "kLoaded = 1")
sc_h743_mutant(optics gate_wave cancel_keeps_ring "segment.trigger = 0;" "")
sc_h743_mutant(optics gate_wave cancel_keeps_runs "segments_.drop();" "")
sc_h743_mutant(optics gate_wave no_darkness "put_stop(end);\n        barrier();" "barrier();")
sc_h743_mutant(optics gate_wave late_unseen "if (!runs_ || dry(before)) {" "if (!runs_) {")
sc_h743_mutant(optics gate_wave enabled_first "write32(kStream + dma::kPar, tim1::kDmar);"
  "write32(kStream + dma::kCr, kSettings | dma::kEnable);\n    write32(kStream + dma::kPar, tim1::kDmar);")
sc_h743_mutant(optics gate_wave not_circular "dma::kCircular | " "")
sc_h743_mutant(optics gate_wave burst_too_short "tim1::burst(tim1::kArr, kWords)" "tim1::burst(tim1::kArr, kWords - 1U)")
sc_h743_mutant(optics gate_wave blip_in_darkness "kNoCount - 1, 0xFFFF" "kNoCount, 0xFFFF")

sc_h743_mutant(optics safety_lines level_before_clear "write32(regs::kPending, moved);\n    const std::uint32_t open = ~read32(regs::kInputs) & kBoth;"
  "const std::uint32_t open = ~read32(regs::kInputs) & kBoth;\n    write32(regs::kPending, moved);")
sc_h743_mutant(optics safety_lines never_cleared "write32(regs::kPending, moved);" "")
sc_h743_mutant(optics safety_lines rising_alone "set_bits(regs::kFalling, kBoth);" "")
sc_h743_mutant(optics safety_lines unmasked_first "clear_bits(regs::kMask, kBoth);" "set_bits(regs::kMask, kBoth);")
sc_h743_mutant(optics safety_lines start_edge_stands "write32(regs::kPending, kBoth);" "")
sc_h743_mutant(optics safety_lines other_port "change_bits(regs::kPortOf8To11, 15U, regs::kPortE);" "")
sc_h743_mutant(optics safety_lines forgets_short_opening "opened_ |= open | moved;" "opened_ |= open;")
sc_h743_mutant(optics safety_lines period_flag_stands "write32(regs::kTim7Sr, ~regs::kUpdateFlag);" "")
sc_h743_mutant(optics safety_lines early_period "write32(regs::kTim7Sr, 0);" "")
sc_h743_mutant(optics safety_lines no_pull "2U << (2U * pin));  // down" "0);")
