# SPDX-License-Identifier: Apache-2.0
# Fails when ctest does not know every case of SOURCES as a test NAME/…: Catch2's listing would leave out silently what it could not list.
set(written 0)
foreach(source IN LISTS SOURCES)
  file(READ ${source} text)
  string(REGEX MATCHALL "\nTEST_CASE\\(" cases "${text}")
  string(REGEX MATCHALL "\nTEST_CASE\\(\"[^\"]*\", *\"[^\"]*\\[(deep|real-time)\\]" apart "${text}")  # of tests of their own
  list(LENGTH cases count)
  list(LENGTH apart count_apart)
  math(EXPR written "${written} + ${count} - ${count_apart}")
endforeach()
execute_process(COMMAND ${CTEST} --test-dir ${BUILD} -N -R "^${NAME}/" OUTPUT_VARIABLE listing COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCH "Total Tests: ([0-9]+)" found "${listing}")
math(EXPR listed "${CMAKE_MATCH_1} - 1")  # this test is one of them
if(written EQUAL 0 OR NOT listed EQUAL written)
  message(FATAL_ERROR "${NAME}: the sources have ${written} cases, ctest lists ${listed}")
endif()
message("${NAME}: ${listed} cases")
