# SPDX-License-Identifier: Apache-2.0
# Files that are compiled into the library, as FOLDER/NAME (haptogram/base/shipped.hpp): written when one of them changes.
function(haptogram_ship folder)
  foreach(file IN LISTS ARGN)
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${file})
    file(READ ${file} content)
    cmake_path(GET file FILENAME name)
    set_property(GLOBAL APPEND_STRING PROPERTY HAPTOGRAM_SHIPPED "    {\"${folder}/${name}\", R\"shipped(${content})shipped\"},\n")
  endforeach()
endfunction()
set(HERE ${CMAKE_CURRENT_LIST_DIR})
file(GLOB ARRAYS CONFIGURE_DEPENDS ${HERE}/arrays/*.toml)
file(GLOB TRANSDUCERS CONFIGURE_DEPENDS ${HERE}/arrays/transducers/*.toml ${HERE}/arrays/transducers/*.csv)
file(GLOB BOARDS CONFIGURE_DEPENDS ${HERE}/../constraints/*.toml)
file(GLOB RIGS CONFIGURE_DEPENDS ${HERE}/arrays/rigs/*.toml)
haptogram_ship(arrays ${ARRAYS})
haptogram_ship(rigs ${RIGS})
haptogram_ship(arrays/transducers ${TRANSDUCERS})
haptogram_ship(boards ${BOARDS})
set(SHIPPED_TABLE ${PROJECT_BINARY_DIR}/shipped_table.cpp)

# Writes the source SHIPPED_TABLE, after the last.
function(haptogram_write_shipped)
  get_property(SHIPPED GLOBAL PROPERTY HAPTOGRAM_SHIPPED)
  file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/shipped_table.cpp @ONLY CONTENT
"// Written by CMake from the files themselves.
#include \"haptogram/base/shipped.hpp\"

namespace haptogram {
namespace {
constexpr ShippedFile files[] = {
@SHIPPED@};
}  // namespace

std::span<const ShippedFile> shipped_table() { return files; }
}  // namespace haptogram
")
endfunction()
