# SPDX-License-Identifier: Apache-2.0
set(dir ${CMAKE_CURRENT_LIST_DIR}/boards/sim)
sc_test(boards_sim_world_test LABEL unit
  SOURCES ${dir}/world/bvh_test.cpp ${dir}/world/machine_errors_test.cpp ${dir}/world/mesh_test.cpp
    ${dir}/world/workpiece_test.cpp ${dir}/world/world_file_test.cpp ${dir}/world/world_test.cpp
  DEPS boards_sim_world)
sc_test(boards_sim_plant_test LABEL unit
  SOURCES ${dir}/plant/cell_plant_test.cpp ${dir}/plant/fault_player_test.cpp ${dir}/plant/fault_script_test.cpp
    ${dir}/plant/galvo_test.cpp ${dir}/plant/laser_test.cpp ${dir}/plant/serial_wire_test.cpp
    ${dir}/plant/shutter_test.cpp ${dir}/plant/source_pins_test.cpp
  DEPS boards_sim_plant firmware_safety)
sc_test(boards_sim_trace_file_test LABEL unit SOURCES ${dir}/machine_keys_test.cpp ${dir}/trace_file_test.cpp DEPS boards_sim)
sc_test(boards_sim_camera_test LABEL unit SOURCES ${dir}/camera/plate_camera_test.cpp DEPS boards_sim_camera)
