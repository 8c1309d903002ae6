# SPDX-License-Identifier: Apache-2.0
set(dir ${CMAKE_CURRENT_LIST_DIR}/boards/linux_rt)
sc_test(unit_boards_linux_rt LABEL unit
  SOURCES ${dir}/allocation_watch_test.cpp ${dir}/drive_bus_test.cpp ${dir}/gpio_lines_test.cpp ${dir}/host_link_test.cpp ${dir}/laser_head_test.cpp ${dir}/lines_test.cpp
    ${dir}/pacer_test.cpp ${dir}/service_notify_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/boards/machine_file/machine_file_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/boards/event_device/event_packets_test.cpp ${CMAKE_CURRENT_LIST_DIR}/boards/port/port_test.cpp
  DEPS boards_linux_rt boards_machine_file)
