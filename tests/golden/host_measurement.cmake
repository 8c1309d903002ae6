# SPDX-License-Identifier: Apache-2.0
find_package(Python3 REQUIRED COMPONENTS Interpreter)
sc_test(golden_measure_test LABEL golden
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/host/measurement/station_test.cpp
  DEPS host_measurement nlohmann_json::nlohmann_json)
add_test(NAME golden.measure.worked_by_hand
  COMMAND Python3::Interpreter -B ${CMAKE_CURRENT_LIST_DIR}/measure/work_by_hand.py --check)
set_tests_properties(golden.measure.worked_by_hand PROPERTIES LABELS golden TIMEOUT 60)
