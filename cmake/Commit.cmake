# SPDX-License-Identifier: Apache-2.0
# cmake -D SOURCE=… -D OUTPUT=… -P Commit.cmake: writes the commit of the sources as a header, when it is another than before.
# `git archive` writes the commit into commit.txt; elsewhere git is asked.
cmake_minimum_required(VERSION 3.25)
file(STRINGS ${CMAKE_CURRENT_LIST_DIR}/commit.txt commit LIMIT_COUNT 1)
if(commit MATCHES "Format")
  execute_process(COMMAND git -C ${SOURCE} describe --always --dirty --exclude=* OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE
    ERROR_QUIET RESULT_VARIABLE failed)
  if(failed)
    set(commit unknown)
  endif()
endif()
file(CONFIGURE OUTPUT ${OUTPUT} CONTENT [[constexpr auto commit = "@commit@";
]] @ONLY)
