# SPDX-License-Identifier: Apache-2.0
set(dir ${CMAKE_CURRENT_LIST_DIR}/host)
sc_test(host_measurement_test LABEL unit TIMEOUT 120
  SOURCES ${dir}/measurement/station_test.cpp ${dir}/measurement/robot_frames_test.cpp
  DEPS host_measurement)
sc_test(host_vision_test LABEL unit TIMEOUT 120
  SOURCES ${dir}/vision/board_test.cpp ${dir}/vision/camera_test.cpp ${dir}/vision/circle_pose_test.cpp ${dir}/vision/marker_test.cpp ${dir}/vision/spot_test.cpp
  DEPS host_vision)
