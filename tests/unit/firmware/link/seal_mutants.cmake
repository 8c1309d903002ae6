# SPDX-License-Identifier: Apache-2.0
# Ablation of the sealed link: one rule is taken out of a copy of the source, and the tests of seal_test.cpp must fail.
set(SC_SEAL_TESTS "${CMAKE_CURRENT_LIST_DIR}/seal_test.cpp")

# name: of the mutant; file: of firmware/link; from, to: texts.
function(sc_seal_mutant name file from to)
  set(source "${PROJECT_SOURCE_DIR}/firmware/link/${file}")
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${source}")
  file(READ "${source}" text)
  string(REPLACE "${from}" "${to}" mutant "${text}")
  if(mutant STREQUAL text)
    message(FATAL_ERROR "seal mutant ${name}: ${file} has no '${from}' to take out")
  endif()
  set(out "${PROJECT_BINARY_DIR}/seal_mutants/${name}.cpp")
  file(CONFIGURE OUTPUT "${out}" CONTENT "${mutant}" @ONLY)
  # Objects of the program itself come before those of the library.
  add_executable(seal_mutant_${name} $<TARGET_OBJECTS:seal_tests> "${out}")
  target_link_libraries(seal_mutant_${name} PRIVATE sc_warnings sc_sanitizers sc_control_path firmware_link shared_link
    GTest::gtest GTest::gtest_main)
  set_target_properties(seal_mutant_${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/tests")
  add_test(NAME unit.seal_mutant_${name} COMMAND seal_mutant_${name} --gtest_brief=1)
  set_tests_properties(unit.seal_mutant_${name} PROPERTIES LABELS unit WILL_FAIL TRUE TIMEOUT 60)
endfunction()

add_library(seal_tests OBJECT "${SC_SEAL_TESTS}")
target_link_libraries(seal_tests PRIVATE sc_warnings sc_sanitizers firmware_link shared_link GTest::gtest)

sc_seal_mutant(no_tag seal_gate.cpp "if (!crypto::same_tag(payload(at).subspan(size), run_.tag())) {" "if (size > kBytes) {")
sc_seal_mutant(no_counter seal_gate.cpp "if (static_cast<std::uint16_t>(newest - low) < kLateWindow) {"
  "if (kLateWindow == 0) {")
sc_seal_mutant(no_proof seal_gate.cpp "if (!open_ || !crypto::same_tag(hello_.proof, run_.tag())) {" "if (!open_) {")
sc_seal_mutant(challenge_twice seal_gate.cpp "open_ = due_ = false;\n    live_ = true;" "due_ = false;\n    live_ = true;")
sc_seal_mutant(no_entropy seal_gate.cpp "draw.put_bytes(secret.entropy);"
  "draw.put_bytes(std::array<std::uint8_t, sizeof(secret.entropy)>{});")
sc_seal_mutant(nonce_stands seal_gate.cpp ".put(challenge_.challenge)" ".put(std::uint32_t{0})")
sc_seal_mutant(no_expiry endpoint_seal.cpp "        gate_.end_session();" "        static_cast<void>(0);")
sc_seal_mutant(unsealed_too endpoint_seal.cpp "    } else if (gate_.live()) {\n        gate_.push(envelope);"
  "    } else if (gate_.live()) {\n        take(envelope);")
