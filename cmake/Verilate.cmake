# SPDX-License-Identifier: Apache-2.0
# haptogram_verilate(TARGET PREFIX MODULE SOURCES FILE… [INCLUDE_DIRS FOLDER…] [TRACE] [COVERAGE] [OPTIONS …])
# Adds to TARGET the class PREFIX, which Verilator makes of MODULE when the project is built. TRACE: it can write FST files. OPTIONS: of Verilator.
# A class is two objects: what runs in every clock, optimised, and what runs once, not. Loops over many channels stay loops, and long functions
# are cut, because a compiler's time grows faster than a function does.
include_guard()
set(HAPTOGRAM_VERILATE_DIR ${CMAKE_CURRENT_LIST_DIR})

# Verilator's own run time, once for all models.
function(haptogram_verilator_library)
  set(include ${VERILATOR_ROOT}/include)
  add_library(haptogram_verilated STATIC ${include}/verilated.cpp ${include}/verilated_dpi.cpp ${include}/verilated_fst_c.cpp ${include}/verilated_threads.cpp
    ${include}/verilated_cov.cpp)
  set_target_properties(haptogram_verilated PROPERTIES UNITY_BUILD OFF SYSTEM ON)
  target_include_directories(haptogram_verilated SYSTEM PUBLIC ${include} ${include}/vltstd)
  target_compile_features(haptogram_verilated PUBLIC cxx_std_20)
  target_compile_options(haptogram_verilated PRIVATE -O2 -w)
  find_package(Threads REQUIRED)
  target_link_libraries(haptogram_verilated PUBLIC Threads::Threads ZLIB::ZLIB)
endfunction()

function(haptogram_verilate target prefix module)
  cmake_parse_arguments(PARSE_ARGV 3 ARG "TRACE;COVERAGE" "" "SOURCES;INCLUDE_DIRS;OPTIONS")
  if(NOT TARGET haptogram_verilated)
    haptogram_verilator_library()
  endif()
  set(folder ${CMAKE_CURRENT_BINARY_DIR}/${target}_${prefix})
  set(options -O3 --output-split-cfuncs 300 --x-assign fast --x-initial unique ${ARG_OPTIONS})
  if(ARG_TRACE)
    list(APPEND options --trace-fst)
  endif()
  if(ARG_COVERAGE)
    list(APPEND options --coverage-line --coverage-toggle)
  endif()
  set(read ${ARG_SOURCES})
  foreach(include IN LISTS ARG_INCLUDE_DIRS)
    list(APPEND options -y ${include})
    file(GLOB found CONFIGURE_DEPENDS ${include}/*.v ${include}/*.vh ${include}/tables/*.vh)
    list(APPEND read ${found})
  endforeach()
  list(REMOVE_DUPLICATES read)
  set(sources ${folder}/${prefix}_fast.cpp ${folder}/${prefix}_slow.cpp)
  # With equal inputs Verilator writes nothing anew, and nothing is compiled again.
  add_custom_command(OUTPUT ${sources} BYPRODUCTS ${folder}/${prefix}.h ${folder}/${prefix}___024root.h
    COMMAND ${VERILATOR_BIN} --cc --make cmake --Mdir ${folder} --prefix ${prefix} --top ${module} ${options} ${ARG_SOURCES}
    COMMAND ${CMAKE_COMMAND} -D FOLDER=${folder} -D PREFIX=${prefix} -P ${HAPTOGRAM_VERILATE_DIR}/VerilatedClass.cmake
    DEPENDS ${read} ${HAPTOGRAM_VERILATE_DIR}/VerilatedClass.cmake COMMENT "Verilating ${module} as ${prefix} for ${target}" VERBATIM)
  target_sources(${target} PRIVATE ${sources})
  target_include_directories(${target} SYSTEM PUBLIC ${folder})
  target_link_libraries(${target} PUBLIC haptogram_verilated)
  # It is not ours to check, and takes half an hour to compile with sanitizers.
  set(common -w)
  if(HAPTOGRAM_SANITIZE)
    list(APPEND common -fno-sanitize=all -g0)
  endif()
  set_source_files_properties(${folder}/${prefix}_fast.cpp PROPERTIES COMPILE_OPTIONS "-O2;${common}" SKIP_UNITY_BUILD_INCLUSION ON)
  set_source_files_properties(${folder}/${prefix}_slow.cpp PROPERTIES COMPILE_OPTIONS "-O0;${common}" SKIP_UNITY_BUILD_INCLUSION ON)
endfunction()
