# SPDX-License-Identifier: Apache-2.0
set(dir ${CMAKE_CURRENT_LIST_DIR}/host/registration)
sc_test(host_registration_test LABEL unit TIMEOUT 120
  SOURCES ${dir}/chain_test.cpp ${dir}/match_test.cpp ${dir}/stitch_test.cpp
  DEPS host_registration)
