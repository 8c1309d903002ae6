# SPDX-License-Identifier: Apache-2.0
sc_test(unit_motion LABEL unit
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/firmware/motion/profile_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/firmware/motion/axis_geometry_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/shared/machine/axis_map_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/firmware/motion/move_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/firmware/motion/stage_curve_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/firmware/laser/xy2_100_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/firmware/laser/field_map_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/firmware/laser/frame_polynomial_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/firmware/laser/head_proof_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/firmware/laser/mopa_serial_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/firmware/laser/power_port_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/firmware/laser/pulse_placer_test.cpp
  DEPS firmware_motion firmware_laser firmware_hal shared_link)
sc_test(unit_basics LABEL unit
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/shared/math/scalar_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/shared/math/angle_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/shared/geometry/frames_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/shared/units/quantity_test.cpp
  DEPS shared_math shared_geometry shared_units)
sc_test(unit_axis_follower LABEL unit
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/firmware/controller/axis_follower_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/firmware/controller/black_box_test.cpp
          ${CMAKE_CURRENT_LIST_DIR}/firmware/motion/error_predictor_test.cpp
  DEPS firmware_controller)
