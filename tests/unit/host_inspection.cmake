# SPDX-License-Identifier: Apache-2.0
set(dir ${CMAKE_CURRENT_LIST_DIR}/host/inspection)
sc_test(host_inspection_distance_test LABEL unit
  SOURCES ${dir}/distance_field_test.cpp ${PROJECT_SOURCE_DIR}/tests/bench/allowance_workload.cpp
  DEPS host_inspection)
sc_test(host_inspection_part_test LABEL unit
  SOURCES ${dir}/faces_test.cpp ${dir}/part_zeros_test.cpp
  DEPS host_inspection)
sc_test(host_inspection_alignment_test LABEL unit
  SOURCES ${dir}/alignment_test.cpp ${PROJECT_SOURCE_DIR}/tests/bench/allowance_workload.cpp
  DEPS host_inspection)
sc_test(host_inspection_borrowing_test LABEL unit
  SOURCES ${dir}/borrowing_test.cpp ${PROJECT_SOURCE_DIR}/tests/bench/allowance_workload.cpp
  DEPS host_inspection)
sc_test(host_inspection_datum_line_test LABEL unit
  SOURCES ${dir}/datum_line_test.cpp ${PROJECT_SOURCE_DIR}/tests/bench/allowance_workload.cpp
  DEPS host_inspection)
sc_test(host_inspection_report_test LABEL unit
  SOURCES ${dir}/report_test.cpp
  DEPS host_inspection)
sc_test(host_inspection_what_if_test LABEL unit
  SOURCES ${dir}/what_if_test.cpp ${PROJECT_SOURCE_DIR}/tests/bench/allowance_workload.cpp
  DEPS host_inspection)
sc_test(host_inspection_uncertainty_test LABEL unit
  SOURCES ${dir}/uncertainty_test.cpp ${PROJECT_SOURCE_DIR}/tests/bench/allowance_workload.cpp
  DEPS host_inspection)
