# SPDX-License-Identifier: Apache-2.0
# The fault campaign. Its host is that of the tests, and it sees the plant's pins: no layer may hold it.
if(SC_SIM)
  find_package(nlohmann_json REQUIRED)
  find_package(Python3 REQUIRED COMPONENTS Interpreter)
  file(MAKE_DIRECTORY "${PROJECT_BINARY_DIR}/include/tests")
  file(CREATE_LINK "${PROJECT_SOURCE_DIR}/tests" "${PROJECT_BINARY_DIR}/include/tests/tests" SYMBOLIC)
  set(sc_faults "${CMAKE_CURRENT_LIST_DIR}/faults")

  add_library(fault_campaign OBJECT ${sc_faults}/main.cpp ${sc_faults}/campaign.cpp ${sc_faults}/fault_oracle.cpp
    ${sc_faults}/faulty_cell.cpp ${sc_faults}/bench_board.cpp ${sc_faults}/once_each.cpp ${sc_faults}/reactions.cpp
    "${PROJECT_SOURCE_DIR}/tests/sim/firmware/controller/cell_rig.cpp")
  target_include_directories(fault_campaign PUBLIC "${PROJECT_BINARY_DIR}/include/tests")
  target_compile_definitions(fault_campaign PRIVATE SC_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  target_link_libraries(fault_campaign PUBLIC sc_warnings sc_sanitizers boards_sim firmware_controller shared_link
    shared_path shared_trace shared_hash nlohmann_json::nlohmann_json fmt::fmt)
  # Rounding is changed on purpose; nothing may be computed ahead of it.
  set_source_files_properties(${sc_faults}/bench_board.cpp PROPERTIES COMPILE_OPTIONS -frounding-math)

  add_executable(scribecell-fault-bench ${sc_faults}/no_rules.cpp)
  target_link_libraries(scribecell-fault-bench PRIVATE fault_campaign)

  # The same with copies of the firmware's sources whose rules can be taken out. Only this program has them.
  set(copies "${PROJECT_BINARY_DIR}/fault_mutants")
  set(sources firmware/safety/frame_guard.cpp firmware/safety/supervisor.cpp firmware/controller/controller.cpp
    firmware/controller/controller_watch.cpp firmware/controller/job_runner.cpp firmware/link/job_stream.cpp
    boards/sim/plant/cell_plant.cpp)
  list(TRANSFORM sources PREPEND "${copies}/" OUTPUT_VARIABLE mutated)
  list(TRANSFORM sources PREPEND "${PROJECT_SOURCE_DIR}/" OUTPUT_VARIABLE originals)
  add_custom_command(OUTPUT ${mutated} "${copies}/mutants.cpp"
    COMMAND Python3::Interpreter -B "${sc_faults}/mutate.py" "${PROJECT_SOURCE_DIR}" "${copies}"
    DEPENDS ${originals} "${sc_faults}/mutate.py" VERBATIM)
  add_library(fault_mutants OBJECT ${mutated} "${copies}/mutants.cpp")
  target_include_directories(fault_mutants PRIVATE "${PROJECT_BINARY_DIR}/include/tests")
  target_link_libraries(fault_mutants PRIVATE sc_sanitizers boards_sim firmware_controller)
  target_compile_options(fault_mutants PRIVATE -include "${sc_faults}/rules.hpp" -ffp-contract=off -fno-math-errno)
  target_compile_definitions(fault_mutants PRIVATE EIGEN_DONT_VECTORIZE)
  add_executable(scribecell-fault-mutants $<TARGET_OBJECTS:fault_mutants>)
  target_link_libraries(scribecell-fault-mutants PRIVATE fault_campaign)
  set_target_properties(scribecell-fault-mutants PROPERTIES LINKER_LANGUAGE CXX)
  set_target_properties(scribecell-fault-bench scribecell-fault-mutants PROPERTIES
    RUNTIME_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/bin")
  # The short campaign, and a rule that is missed; `scribecell bench faults` runs all of both.
  if(NOT SC_SANITIZE)
    add_test(NAME sim.faults_brief COMMAND scribecell-fault-bench --brief --strict --check-page
      "${PROJECT_SOURCE_DIR}/docs/hazards.md")
    add_test(NAME sim.faults_find_a_missing_rule COMMAND scribecell-fault-mutants --mutants --only 41 --brief --strict)
    set_tests_properties(sim.faults_brief sim.faults_find_a_missing_rule PROPERTIES LABELS sim TIMEOUT 300)
  endif()
endif()
