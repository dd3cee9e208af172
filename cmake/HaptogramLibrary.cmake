# SPDX-License-Identifier: Apache-2.0
# How a layer becomes a library, and how all of them are installed: haptogram::LAYER each, haptogram::haptogram for all.
include_guard()
set_property(GLOBAL PROPERTY HAPTOGRAM_LAYERS "")

# haptogram_library(NAME SOURCES... [INTERNAL HEADERS...])
# The library haptogram_NAME of haptogram/NAME beside the caller, which others link as haptogram::NAME. INTERNAL headers are for the
# project's own sources: they are not installed, and may include what a user of the library need not have. After it,
# target_link_libraries says what the layer uses: PUBLIC what its headers include, PRIVATE what its sources do, and
# PRIVATE $<BUILD_INTERFACE:...> what has headers only, which nobody needs to link against the finished library.
# A library from outside that is PUBLIC or PRIVATE also stands in haptogramConfig.cmake.in and haptogram.pc.in.
function(haptogram_library name)
  cmake_parse_arguments(PARSE_ARGV 1 ARG "" "" "INTERNAL")
  set(folder ${CMAKE_CURRENT_SOURCE_DIR}/haptogram/${name})
  list(TRANSFORM ARG_UNPARSED_ARGUMENTS PREPEND ${folder}/)
  add_library(haptogram_${name} STATIC ${ARG_UNPARSED_ARGUMENTS})
  add_library(haptogram::${name} ALIAS haptogram_${name})
  set_target_properties(haptogram_${name} PROPERTIES EXPORT_NAME ${name}
    POSITION_INDEPENDENT_CODE ON)  # for shared libraries, such as the Python module
  target_compile_features(haptogram_${name} PUBLIC cxx_std_20)
  target_include_directories(haptogram_${name} PUBLIC $<BUILD_INTERFACE:${CMAKE_CURRENT_SOURCE_DIR}>)
  target_link_libraries(haptogram_${name} PRIVATE fmt::fmt $<BUILD_INTERFACE:haptogram_warnings>)

  # Highway's loops are compiled from one source for each kind of processor; in a native build for this one alone.
  foreach(source IN LISTS ARG_UNPARSED_ARGUMENTS)
    file(STRINGS ${source} loops REGEX "include <hwy/foreach_target.h>")
    if(loops)
      set_source_files_properties(${source} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
      if(HAPTOGRAM_NATIVE)
        set_source_files_properties(${source} PROPERTIES COMPILE_OPTIONS "-O2;-march=native" COMPILE_DEFINITIONS HWY_COMPILE_ONLY_STATIC)
      endif()
    endif()
  endforeach()

  file(GLOB headers CONFIGURE_DEPENDS ${folder}/*.hpp)
  foreach(header IN LISTS ARG_INTERNAL)
    if(NOT EXISTS ${folder}/${header})
      message(FATAL_ERROR "haptogram_library(${name} ... INTERNAL ${header}): there is no such header")
    endif()
    list(REMOVE_ITEM headers ${folder}/${header})
  endforeach()
  set_property(TARGET haptogram_${name} PROPERTY HAPTOGRAM_HEADERS ${headers})
  set_property(GLOBAL APPEND PROPERTY HAPTOGRAM_LAYERS ${name})
endfunction()

# What a layer is linked with: the layers below it, with all that are below those, and targets from outside.
function(haptogram_needs_of layer below outside)
  set(layers ${layer})
  set(others "")
  get_target_property(links haptogram_${layer} INTERFACE_LINK_LIBRARIES)
  foreach(link IN LISTS links)
    string(REGEX REPLACE "^\\$<LINK_ONLY:(.*)>$" "\\1" link "${link}")
    if(link MATCHES "^haptogram_(.*)$")
      haptogram_needs_of(${CMAKE_MATCH_1} more ignored)
      list(APPEND layers ${more})
    elseif(NOT link MATCHES "^\\$<BUILD_INTERFACE")
      list(APPEND others ${link})
    endif()
  endforeach()
  list(REMOVE_DUPLICATES layers)
  set(${below} ${layers} PARENT_SCOPE)
  set(${outside} ${others} PARENT_SCOPE)
endfunction()

# After the last layer.
function(haptogram_install_libraries)
  get_property(layers GLOBAL PROPERTY HAPTOGRAM_LAYERS)
  list(TRANSFORM layers PREPEND haptogram_ OUTPUT_VARIABLE targets)
  # Not called haptogram, which is the program.
  add_library(haptogram_libraries INTERFACE)
  add_library(haptogram::haptogram ALIAS haptogram_libraries)
  set_target_properties(haptogram_libraries PROPERTIES EXPORT_NAME haptogram)
  target_link_libraries(haptogram_libraries INTERFACE ${targets})
  if(NOT HAPTOGRAM_INSTALL)
    return()
  endif()

  include(CMakePackageConfigHelpers)
  set(package ${CMAKE_INSTALL_LIBDIR}/cmake/haptogram)
  # Each layer has an export of its own, so that who wants one component need not have what the others are linked with.
  set(HAPTOGRAM_NEEDS "")
  foreach(layer IN LISTS layers)
    get_target_property(headers haptogram_${layer} HAPTOGRAM_HEADERS)
    install(FILES ${headers} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/haptogram/${layer} COMPONENT devel)
    install(TARGETS haptogram_${layer} EXPORT haptogram_${layer}
      ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT devel INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
    install(EXPORT haptogram_${layer} NAMESPACE haptogram:: DESTINATION ${package} FILE ${layer}.cmake COMPONENT devel)
    haptogram_needs_of(${layer} below outside)
    string(APPEND HAPTOGRAM_NEEDS "set(haptogram_layers_${layer} ${below})\nset(haptogram_outside_${layer} ${outside})\n")
  endforeach()
  install(TARGETS haptogram_libraries EXPORT haptogram_libraries)
  install(EXPORT haptogram_libraries NAMESPACE haptogram:: DESTINATION ${package} FILE all.cmake COMPONENT devel)
  set(template ${CMAKE_CURRENT_FUNCTION_LIST_DIR})
  set(HAPTOGRAM_LAYERS ${layers})
  configure_package_config_file(${template}/haptogramConfig.cmake.in haptogramConfig.cmake INSTALL_DESTINATION ${package})
  # Before 1.0 a minor version may change the interface.
  write_basic_package_version_file(haptogramConfigVersion.cmake COMPATIBILITY SameMinorVersion)
  install(FILES ${CMAKE_CURRENT_BINARY_DIR}/haptogramConfig.cmake ${CMAKE_CURRENT_BINARY_DIR}/haptogramConfigVersion.cmake
    DESTINATION ${package} COMPONENT devel)

  # A static linker takes from a library what those before it have asked for, so the topmost layer comes first.
  list(REVERSE targets)
  list(TRANSFORM targets PREPEND -l)
  list(JOIN targets " " HAPTOGRAM_PC_LIBRARIES)
  set(HAPTOGRAM_PC_PARTS "")
  if(HAPTOGRAM_FTDI)
    string(APPEND HAPTOGRAM_PC_PARTS ", libftdi1, libusb-1.0")
  endif()
  if(scattering IN_LIST HAPTOGRAM_WITH AND HAPTOGRAM_OPENBLAS)
    string(APPEND HAPTOGRAM_PC_PARTS ", openblas")
  endif()
  if(formats IN_LIST HAPTOGRAM_WITH)
    string(APPEND HAPTOGRAM_PC_PARTS ", pugixml")
  endif()
  if(live IN_LIST HAPTOGRAM_WITH)
    string(APPEND HAPTOGRAM_PC_PARTS ", libpng, bullet")
  endif()
  # Relative to the .pc file, so that an installed tree can be moved.
  file(RELATIVE_PATH HAPTOGRAM_PC_PREFIX /prefix/${CMAKE_INSTALL_LIBDIR}/pkgconfig /prefix)
  configure_file(${template}/haptogram.pc.in haptogram.pc @ONLY)
  install(FILES ${CMAKE_CURRENT_BINARY_DIR}/haptogram.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT devel)
endfunction()
