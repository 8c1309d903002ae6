# SPDX-License-Identifier: Apache-2.0
set(dir ${CMAKE_CURRENT_LIST_DIR}/boards/linux_rt)
sc_test(boards_linux_rt_test LABEL sim SOURCES ${dir}/control_loop_test.cpp ${dir}/program_test.cpp
  DEPS boards_linux_rt boards_sim boards_sim_events shared_link shared_path nlohmann_json::nlohmann_json)
if(TARGET boards_linux_rt_test)
  add_dependencies(boards_linux_rt_test scribecell-rt scribecell-events)
endif()
