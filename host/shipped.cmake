# SPDX-License-Identifier: Apache-2.0
# Files that are compiled into the library, as FOLDER/NAME (haptogram/base/shipped.hpp): written when one of them changes.
set(SHIPPED "")
function(haptogram_ship folder)
  foreach(file IN LISTS ARGN)
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${file})
    file(READ ${file} content)
    cmake_path(GET file FILENAME name)
    string(APPEND SHIPPED "    {\"${folder}/${name}\", R\"shipped(${content})shipped\"},\n")
  endforeach()
  set(SHIPPED "${SHIPPED}" PARENT_SCOPE)
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
file(GLOB PERCEPTION CONFIGURE_DEPENDS ${HERE}/haptogram/perception/*.toml)
haptogram_ship(perception ${PERCEPTION})

# After the last; SHIPPED_TABLE is the source that has them all.
function(haptogram_write_shipped)
  set(table ${CMAKE_CURRENT_BINARY_DIR}/shipped_table.cpp)
  file(CONFIGURE OUTPUT ${table} @ONLY CONTENT
"// Written by CMake from the files themselves.
#include \"haptogram/base/shipped_table.hpp\"

namespace haptogram {
namespace {
constexpr ShippedFile files[] = {
@SHIPPED@};
}  // namespace

std::span<const ShippedFile> shipped_table() { return files; }
}  // namespace haptogram
")
  set(SHIPPED_TABLE ${table} PARENT_SCOPE)
endfunction()
