# SPDX-License-Identifier: Apache-2.0
# The files for outsiders against captures, by tshark and canmatrix, which share no code with us.
if(SC_HOST AND SC_SIM)
  set(dir ${CMAKE_CURRENT_LIST_DIR}/host/protocol)
  add_executable(scribecell-protocol-sample ${dir}/sample_capture.cpp)
  target_link_libraries(scribecell-protocol-sample PRIVATE sc_warnings sc_sanitizers host_formats shared_link)
  set_target_properties(scribecell-protocol-sample PROPERTIES RUNTIME_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/bin")
  if(NOT SC_SANITIZE)
    foreach(carrier serial can canfd)
      # The system's Python: canmatrix is a Debian package.
      add_test(NAME sim.protocol_${carrier} COMMAND /usr/bin/python3 -B ${dir}/check.py $<TARGET_FILE:scribecell>
        $<TARGET_FILE:scribecell-protocol-sample> "${PROJECT_SOURCE_DIR}/docs/protocol" "${PROJECT_BINARY_DIR}/protocol-check"
        ${carrier})
      set_tests_properties(sim.protocol_${carrier} PROPERTIES LABELS sim TIMEOUT 300)
    endforeach()
  endif()
endif()
