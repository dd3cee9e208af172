# SPDX-License-Identifier: Apache-2.0
# haptogram_module_test(NAME MODULE CASES FILE… [SOURCES FILE …] [PARAMETERS P=V …] [LIBRARIES …] [PROGRAM NAME [COVERAGE] [VERILATOR …]])
# The executable test_module_NAME: the cases in these files on rtl/MODULE.v, or on the module of that name in SOURCES, Verilated as the class
# VMODULE with these parameters, which the cases know as PARAMETER_P. Each case is a test of ctest, module_NAME/CASE, with the label "modules". What the module's proof asserts is
# checked in every clock. PROGRAM: what the executable is called instead when it is no test by itself; then VERILATOR has the options in place of the checks.
function(haptogram_module_test name module)
  cmake_parse_arguments(PARSE_ARGV 2 ARG "COVERAGE" "PROGRAM" "CASES;SOURCES;PARAMETERS;LIBRARIES;VERILATOR")
  if(NOT ARG_SOURCES)
    file(GLOB ARG_SOURCES ${PROJECT_SOURCE_DIR}/rtl/${module}.v ${PROJECT_SOURCE_DIR}/rtl/amplitudes/${module}.v ${PROJECT_SOURCE_DIR}/rtl/time/${module}.v)
  endif()
  list(TRANSFORM ARG_PARAMETERS PREPEND -G OUTPUT_VARIABLE generics)
  list(TRANSFORM ARG_PARAMETERS PREPEND PARAMETER_)
  if(NOT ARG_PROGRAM)
    set(ARG_VERILATOR -Wall --assert -DFORMAL)
  endif()
  if(ARG_COVERAGE)
    set(ARG_COVERAGE COVERAGE)
  else()
    set(ARG_COVERAGE "")
  endif()
  add_library(module_${name} STATIC)
  haptogram_verilate(module_${name} V${module} ${module} SOURCES ${ARG_SOURCES} ${ARG_COVERAGE}
    INCLUDE_DIRS ${PROJECT_SOURCE_DIR}/rtl ${PROJECT_SOURCE_DIR}/rtl/amplitudes ${PROJECT_SOURCE_DIR}/rtl/time ${PROJECT_SOURCE_DIR}/rtl/net ${PROJECT_SOURCE_DIR}/rtl/sdram OPTIONS ${ARG_VERILATOR} ${generics})
  list(TRANSFORM ARG_CASES PREPEND ${CMAKE_CURRENT_SOURCE_DIR}/ OUTPUT_VARIABLE sources)
  add_executable(test_module_${name} ${sources})
  target_link_libraries(test_module_${name} PRIVATE haptogram_test_main module_${name} ${ARG_LIBRARIES})
  target_compile_definitions(test_module_${name} PRIVATE ${ARG_PARAMETERS})
  # Not all of haptogram_warnings: the types of the module's ports follow from its parameters.
  target_compile_options(test_module_${name} PRIVATE -O2 -Wall -Wextra)
  if(ARG_PROGRAM)
    set_target_properties(test_module_${name} PROPERTIES OUTPUT_NAME ${ARG_PROGRAM})
  else()
    haptogram_discover(module_${name} modules "${sources}" 300)
  endif()
endfunction()

# haptogram_port_test(NAME CASES FILE… [SOURCES FILE…] [PROGRAM NAME [VERILATOR …]]): the same of the network port, quick to reach its limits;
# the numbers are also those of tests/mutation/mutation.toml.
function(haptogram_port_test name)
  haptogram_module_test(${name} udp_link PARAMETERS RX_BITS=12 PEER_CLOCKS=40000 GATHER_CLOCKS=60 ${ARGN})
endfunction()

# haptogram_net_test(NAME BOARD CASES FILE… [SOURCES FILE…] [PROGRAM NAME [VERILATOR …]]): the same of the whole instrument behind a network port, as it is on a board.
function(haptogram_net_test name board)
  cmake_parse_arguments(PARSE_ARGV 2 ARG "" "PROGRAM" "CASES;SOURCES;VERILATOR")
  set(modules ${PROJECT_SOURCE_DIR}/tests/modules)
  set(parameters "")
  foreach(parameter value IN ZIP_LISTS HAPTOGRAM_PARAMETERS HAPTOGRAM_CONFIGURATION_${board})
    list(APPEND parameters ${parameter}=${value})
  endforeach()
  haptogram_module_test(${name} net_core_bench CASES ${ARG_CASES} SOURCES ${modules}/net_core_bench.v ${ARG_SOURCES} PARAMETERS ${parameters}
    LIBRARIES haptogram_link haptogram_solve PROGRAM ${ARG_PROGRAM} VERILATOR ${ARG_VERILATOR})
  target_include_directories(test_module_${name} PRIVATE ${PROJECT_SOURCE_DIR}/sim ${modules})
endfunction()
