# SPDX-License-Identifier: Apache-2.0
# Fails when ctest does not know every case of SOURCES as a test NAME/…: Catch2's listing would leave out silently what it could not list.
set(written 0)
foreach(source IN LISTS SOURCES)
  file(STRINGS ${source} lines REGEX "^TEST_CASE\\(" ENCODING UTF-8)
  list(FILTER lines EXCLUDE REGEX "\\[(deep|real-time)\\]")  # of tests of their own
  list(LENGTH lines count)
  math(EXPR written "${written} + ${count}")
endforeach()
execute_process(COMMAND ${CTEST} --test-dir ${BUILD} -N -R "^${NAME}/" OUTPUT_VARIABLE listing COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCH "Total Tests: ([0-9]+)" found "${listing}")
math(EXPR listed "${CMAKE_MATCH_1} - 1")  # this test is one of them
if(written EQUAL 0 OR NOT listed EQUAL written)
  message(FATAL_ERROR "${NAME}: the sources have ${written} cases, ctest lists ${listed}")
endif()
message("${NAME}: ${listed} cases")
