# SPDX-License-Identifier: Apache-2.0
sc_test(host_verification_burns_test LABEL unit
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/host/verification/burn_finder_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/host/verification/line_fit_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/host/verification/path_follower_test.cpp
  DEPS host_verification)
sc_test(host_verification_samples_test LABEL unit
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/host/verification/sample_checker_test.cpp
  DEPS host_verification)
sc_test(host_verification_accuracy_test LABEL unit
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/host/verification/accuracy_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/host/verification/error_fit_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/host/verification/world_errors_test.cpp
  DEPS host_verification)
sc_test(host_verification_report_test LABEL unit
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/host/verification/report_test.cpp
  DEPS host_verification)
sc_test(host_verification_motion_test LABEL unit
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/host/verification/motion_checker_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/host/verification/motion_svg_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/host/verification/motion_trace_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/host/verification/path_deviation_test.cpp
  DEPS host_verification)
sc_test(host_verification_pulses_test LABEL unit
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/host/verification/pulse_checker_test.cpp
  DEPS host_verification)
sc_test(host_verification_table_test LABEL unit
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/host/verification/table_check_test.cpp
  DEPS host_verification)
