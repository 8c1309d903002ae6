# SPDX-License-Identifier: Apache-2.0
# OpenCV's hand-eye methods as a peer, where the tier bench is installed. calib3d drags in 400 MB: nothing that ships links it.
if(SC_HOST)
  find_path(SC_CALIB3D_INCLUDE opencv2/calib3d.hpp PATH_SUFFIXES opencv4)
  find_library(SC_CALIB3D_LIBRARY opencv_calib3d)
  find_library(SC_OPENCV_CORE_LIBRARY opencv_core)
  if(SC_CALIB3D_INCLUDE AND SC_CALIB3D_LIBRARY AND SC_OPENCV_CORE_LIBRARY)
    add_executable(scribecell-hand-eye-peer ${CMAKE_CURRENT_LIST_DIR}/hand_eye_peer.cpp)
    # Its headers are not written for our warnings.
    target_include_directories(scribecell-hand-eye-peer SYSTEM PRIVATE ${SC_CALIB3D_INCLUDE})
    target_compile_options(scribecell-hand-eye-peer PRIVATE -Wall -Wextra -Werror)
    target_link_libraries(scribecell-hand-eye-peer PRIVATE ${SC_CALIB3D_LIBRARY} ${SC_OPENCV_CORE_LIBRARY})
    set_target_properties(scribecell-hand-eye-peer PROPERTIES RUNTIME_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/bin")
  endif()
endif()
