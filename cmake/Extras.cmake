# SPDX-License-Identifier: Apache-2.0
# Which of the folders of extras/ are in this build, each behind those that it needs: HAPTOGRAM_WITH. A folder with a CMakeLists.txt is an
# extra; the line "# Needs: OTHERS" in that file names the extras that it stands on, which come with it. Its packages.cmake, if there is one,
# says what it needs from the system.
include_guard()
file(GLOB found CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/extras/*/CMakeLists.txt)
set(HAPTOGRAM_EVERY_EXTRA "")
foreach(file IN LISTS found)
  cmake_path(GET file PARENT_PATH folder)
  cmake_path(GET folder FILENAME extra)
  list(APPEND HAPTOGRAM_EVERY_EXTRA ${extra})
  file(STRINGS ${file} line REGEX "^# Needs:")
  string(REGEX REPLACE "^# Needs: *" "" line "${line}")
  string(REPLACE " " ";" needs_${extra} "${line}")
endforeach()
list(JOIN HAPTOGRAM_EVERY_EXTRA ", " names)
set(HAPTOGRAM_EXTRAS "all" CACHE STRING "Extras to build: all, or some of ${names}; each brings those that it needs")

set(HAPTOGRAM_WITH "")
set(left ${HAPTOGRAM_EXTRAS})
if(left STREQUAL "all")
  set(left ${HAPTOGRAM_EVERY_EXTRA})
endif()
list(REVERSE left)  # each is put in front
while(left)
  list(POP_FRONT left extra)
  if(NOT extra IN_LIST HAPTOGRAM_EVERY_EXTRA)
    message(FATAL_ERROR "HAPTOGRAM_EXTRAS: there is no extra '${extra}'; there are ${names}")
  endif()
  list(REMOVE_ITEM HAPTOGRAM_WITH ${extra})
  list(PREPEND HAPTOGRAM_WITH ${extra})
  list(APPEND left ${needs_${extra}})
endwhile()
set(HAPTOGRAM_LEFT_OUT ${HAPTOGRAM_EVERY_EXTRA})
list(REMOVE_ITEM HAPTOGRAM_LEFT_OUT ${HAPTOGRAM_WITH})

# haptogram_commands(NAME SOURCES… [LINK LIBRARIES…] [INCLUDE FOLDERS…])
# Sources of the program, in the folder commands/ beside the caller's CMakeLists.txt, one of which has register_NAME(Extras&) (host/cli/extras.hpp).
function(haptogram_commands name)
  cmake_parse_arguments(PARSE_ARGV 1 ARG "" "" "LINK;INCLUDE")
  if(NOT HAPTOGRAM_PROGRAM)
    return()
  endif()
  list(TRANSFORM ARG_UNPARSED_ARGUMENTS PREPEND ${CMAKE_CURRENT_SOURCE_DIR}/commands/)
  set_property(GLOBAL APPEND PROPERTY HAPTOGRAM_REGISTERED ${name})
  set_property(GLOBAL APPEND PROPERTY HAPTOGRAM_COMMAND_SOURCES ${ARG_UNPARSED_ARGUMENTS})
  set_property(GLOBAL APPEND PROPERTY HAPTOGRAM_COMMAND_FOLDERS ${CMAKE_CURRENT_SOURCE_DIR}/commands ${ARG_INCLUDE})
  set_property(GLOBAL APPEND PROPERTY HAPTOGRAM_COMMAND_LIBRARIES ${ARG_LINK})
endfunction()

# The source that registers them, for the program. Simulated boards are no extra, but may be left out, too.
function(haptogram_write_extras file)
  get_property(names GLOBAL PROPERTY HAPTOGRAM_REGISTERED)
  set(left_out ${HAPTOGRAM_LEFT_OUT})
  if(NOT HAPTOGRAM_SIMULATION)
    list(PREPEND left_out "simulation")
  endif()
  list(JOIN left_out ", " LEFT_OUT)
  set(DECLARED "")
  set(CALLED "")
  foreach(name IN LISTS names)
    string(APPEND DECLARED "void register_${name}(Extras& extras);\n")
    string(APPEND CALLED "    register_${name}(extras);\n")
  endforeach()
  file(CONFIGURE OUTPUT ${file} @ONLY CONTENT
"// Written by CMake: what this build has beside the core.
#include \"extras.hpp\"

namespace haptogram::cli {

@DECLARED@
void register_extras([[maybe_unused]] Extras& extras) {
@CALLED@}

std::string_view extras_left_out() { return \"@LEFT_OUT@\"; }

}  // namespace haptogram::cli
")
endfunction()
