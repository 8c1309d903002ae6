# SPDX-License-Identifier: Apache-2.0
set(dir ${CMAKE_CURRENT_LIST_DIR}/boards/sim)
sc_test(boards_sim_cell_test LABEL sim SOURCES ${dir}/cell_test.cpp ${dir}/cell_faults_test.cpp ${dir}/link_line_test.cpp
  DEPS boards_sim shared_link shared_path)
sc_test(boards_sim_lock_step_test LABEL sim SOURCES ${dir}/lock_step_test.cpp DEPS boards_sim)
sc_test(boards_sim_program_test LABEL sim SOURCES ${dir}/program_test.cpp DEPS boards_sim)
if(TARGET boards_sim_program_test)
  add_dependencies(boards_sim_program_test scribecell-cell)
endif()
