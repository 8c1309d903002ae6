# SPDX-License-Identifier: Apache-2.0
sc_test(test_shared_codes LABEL unit SOURCES ${CMAKE_CURRENT_LIST_DIR}/shared/codes/codes_test.cpp DEPS shared_codes)
sc_test(test_galvo_lag LABEL unit SOURCES ${CMAKE_CURRENT_LIST_DIR}/shared/machine/galvo_lag_test.cpp DEPS shared_machine)
