# SPDX-License-Identifier: Apache-2.0
# OpenCV's hand-eye methods and stereo calibration as peers, where the tier bench is installed. calib3d drags in 400 MB: nothing that ships links it.
if(SC_HOST)
  find_path(SC_CALIB3D_INCLUDE opencv2/calib3d.hpp PATH_SUFFIXES opencv4)
  find_library(SC_CALIB3D_LIBRARY opencv_calib3d)
  find_library(SC_OPENCV_CORE_LIBRARY opencv_core)
  if(SC_CALIB3D_INCLUDE AND SC_CALIB3D_LIBRARY AND SC_OPENCV_CORE_LIBRARY)
    foreach(peer hand-eye stereo)
      string(REPLACE "-" "_" source ${peer})
      add_executable(scribecell-${peer}-peer ${CMAKE_CURRENT_LIST_DIR}/${source}_peer.cpp)
      # Its headers are not written for our warnings.
      target_include_directories(scribecell-${peer}-peer SYSTEM PRIVATE ${SC_CALIB3D_INCLUDE})
      target_compile_options(scribecell-${peer}-peer PRIVATE -Wall -Wextra -Werror)
      target_link_libraries(scribecell-${peer}-peer PRIVATE ${SC_CALIB3D_LIBRARY} ${SC_OPENCV_CORE_LIBRARY})
      set_target_properties(scribecell-${peer}-peer PROPERTIES RUNTIME_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/bin")
    endforeach()
  endif()
endif()
