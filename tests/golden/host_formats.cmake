# SPDX-License-Identifier: Apache-2.0
find_package(Python3 REQUIRED COMPONENTS Interpreter)
sc_test(golden_frames_test LABEL golden
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/host/calibration/transforms_test.cpp
  DEPS host_calibration nlohmann_json::nlohmann_json)

# What the scripts work out is what is committed.
add_test(NAME golden.frames.worked_by_hand
  COMMAND Python3::Interpreter -B ${CMAKE_CURRENT_LIST_DIR}/frames/work_by_hand.py --check)
add_test(NAME golden.frames.face90
  COMMAND Python3::Interpreter -B ${CMAKE_CURRENT_LIST_DIR}/frames/make_face90.py
    ${PROJECT_SOURCE_DIR}/examples/ras3dm --check)
set_tests_properties(golden.frames.worked_by_hand golden.frames.face90 PROPERTIES LABELS golden TIMEOUT 60)
