# SPDX-License-Identifier: Apache-2.0
sc_test(property_motion LABEL property TIMEOUT 300
  SOURCES ${CMAKE_CURRENT_LIST_DIR}/firmware/motion/path_motion_test.cpp
  DEPS firmware_motion)
if(TARGET property_motion)
  # All of them where they are quick; the other builds look for what differs there, not for rare paths.
  set(runs 300)
  if(SC_SANITIZE OR NOT CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    set(runs 30)
  endif()
  target_compile_definitions(property_motion PRIVATE SC_RANDOM_RUNS=${runs})
endif()
