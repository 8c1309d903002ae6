# SPDX-License-Identifier: Apache-2.0
# The same bits from every build. ./test builds the others first and sets SC_MATRIX; breaks.cmake records the log.
if(NOT SC_MATRIX OR NOT TARGET scribecell-replay OR NOT TARGET matrix_record)
  return()
endif()
set(sc_builds "${PROJECT_SOURCE_DIR}/build")
# The same job, run by the controller on the Cortex-M7: its outputs, tick by tick, are what its recording holds.
set(sc_m7_row "")
set(sc_m7_log "${PROJECT_BINARY_DIR}/matrix/short_m7.rec")
if(SC_M7)
  add_test(NAME matrix.record_m7 COMMAND matrix_record "${sc_m7_log}" "${sc_builds}/m7/bin/scribecell-mps2-an500.elf")
  set_tests_properties(matrix.record_m7 PROPERTIES LABELS matrix TIMEOUT 300 FIXTURES_SETUP matrix_m7_log)
  set(sc_m7_row --recorded "arm gcc -O3, Cortex-M7" "${sc_m7_log}")
endif()
add_test(NAME matrix.hashes COMMAND Python3::Interpreter -B "${PROJECT_SOURCE_DIR}/tests/matrix/hashes.py"
  "${sc_matrix_log}"
  --build "gcc -O2" $<TARGET_FILE:scribecell-replay>
  --build "gcc -O0" "${sc_builds}/replay-O0/bin/scribecell-replay"
  --build "gcc -O3 -march=x86-64-v3" "${sc_builds}/replay-v3/bin/scribecell-replay"
  --build "clang-19 -O3" "${sc_builds}/clang/bin/scribecell-replay"
  --build "clang-19 -O1, sanitizers" "${sc_builds}/asan/bin/scribecell-replay"
  --build "gcc -O2 -m32 -msse2 -mfpmath=sse" "${sc_builds}/m32/bin/scribecell-replay"
  ${sc_m7_row}
  --needs "gcc -O3 -march=x86-64-v3" avx2,fma,bmi2)
set_tests_properties(matrix.hashes PROPERTIES LABELS matrix TIMEOUT 300 FIXTURES_REQUIRED "matrix_log;matrix_m7_log")
