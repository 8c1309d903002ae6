# SPDX-License-Identifier: Apache-2.0
add_library(stm32h743_board_cell STATIC ${CMAKE_CURRENT_LIST_DIR}/board_cell.cpp ${CMAKE_CURRENT_LIST_DIR}/waves.cpp
  ${CMAKE_CURRENT_LIST_DIR}/wires.cpp)
target_link_libraries(stm32h743_board_cell PRIVATE sc_warnings sc_sanitizers nlohmann_json::nlohmann_json
  PUBLIC boards_stm32h743_loop stm32h743_optics_model stm32h743_link_model boards_sim boards_sim_events)
sc_test(stm32h743_cell LABEL sim SOURCES ${CMAKE_CURRENT_LIST_DIR}/board_cell_test.cpp
  DEPS stm32h743_board_cell)
sc_h743_mutants(loop LIBRARIES boards_stm32h743_loop stm32h743_board_cell PARTS board_loop
  TESTS ${CMAKE_CURRENT_LIST_DIR}/board_cell_test.cpp)
sc_h743_mutant(loop board_loop gate_stays_open "    parts_.gate.shut();\n    if (causes" "    if (causes")
sc_h743_mutant(loop board_loop causes_lost "in.guard_causes = causes_.exchange(0);" "causes_ = 0;")
sc_h743_mutant(loop board_loop allowed_always "allowed_ = next_allowed_.exchange(false);" "allowed_ = true;")
sc_h743_mutant(loop board_loop never_allowed "    next_allowed_ = true;" "")
sc_h743_mutant(loop board_loop lines_stay "    DigitalPort::write(out.digital);\n" "")
sc_h743_mutant(loop board_loop late_unseen "if (windows_ > tick_ + 1)" "if (windows_ < 0)")
sc_h743_mutant(loop board_loop late_plan_unseen "return windows_ == tick_;" "return true;")
sc_h743_mutant(loop board_loop break_unseen "if (in.gate_allowed && !open)" "if (in.gate_allowed && tick_ < 0)")
sc_h743_mutant(loop board_loop status_unseen "in.galvo_status = parts_.status.word();" "in.galvo_status = kGalvoStatusOk;")
sc_h743_mutant(loop board_loop outputs_on_after_failure "    DigitalPort::make_safe();\n}" "}")
sc_h743_mutant(loop board_loop strobes_forgotten "parts_.power.fill(runs, out.clear_power)" "parts_.power.fill({}, out.clear_power)")

add_executable(scribecell-stm32h743-cell ${CMAKE_CURRENT_LIST_DIR}/main.cpp)
target_link_libraries(scribecell-stm32h743-cell PRIVATE sc_warnings sc_sanitizers stm32h743_board_cell CLI11::CLI11)
set_target_properties(scribecell-stm32h743-cell PROPERTIES RUNTIME_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/tests")
if(SC_HOST)
  add_test(NAME sim.stm32h743_main_job COMMAND Python3::Interpreter -B ${CMAKE_CURRENT_LIST_DIR}/main_job.py
    $<TARGET_FILE:scribecell-stm32h743-cell> $<TARGET_FILE:scribecell>)
  set_tests_properties(sim.stm32h743_main_job PROPERTIES LABELS sim TIMEOUT 900 ENVIRONMENT "SCRIBECELL_ROOT=${PROJECT_SOURCE_DIR}")
endif()
