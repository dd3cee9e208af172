# SPDX-License-Identifier: Apache-2.0
# What the build needs from the system. Everything that is missing is told at once, in one line, with the name of the Debian package
# that brings it; off Debian the name is a hint.
set(HAPTOGRAM_MISSING "")

# As find_package(PACKAGE ARGN... REQUIRED); a macro, because find_package leaves its results in the caller's scope.
macro(haptogram_need package debian)
  find_package(${package} ${ARGN} QUIET)
  if(NOT ${package}_FOUND)
    list(APPEND HAPTOGRAM_MISSING "${package} (${debian})")
  endif()
endmacro()

# A program that a test or a generator starts.
function(haptogram_need_program program debian)
  string(MAKE_C_IDENTIFIER "HAPTOGRAM_PATH_OF_${program}" variable)
  find_program(${variable} ${program} PATHS /usr/sbin /sbin)
  mark_as_advanced(${variable})
  if(NOT ${variable})
    set(HAPTOGRAM_MISSING ${HAPTOGRAM_MISSING} "${program} (${debian})" PARENT_SCOPE)
  endif()
endfunction()

# Python modules: pairs of a module's name and its package.
function(haptogram_need_modules)
  if(NOT Python3_FOUND)
    return()
  endif()
  set(missing ${HAPTOGRAM_MISSING})
  while(ARGN)
    list(POP_FRONT ARGN module package)
    execute_process(COMMAND ${Python3_EXECUTABLE} -c
      "import importlib.util, sys; sys.exit(importlib.util.find_spec('${module}') is None)" RESULT_VARIABLE absent)
    if(absent)
      list(APPEND missing "Python's ${module} (${package})")
    endif()
  endwhile()
  set(HAPTOGRAM_MISSING ${missing} PARENT_SCOPE)
endfunction()

# To be called when all of it has been asked for.
function(haptogram_report_missing)
  if(HAPTOGRAM_MISSING)
    list(JOIN HAPTOGRAM_MISSING ", " names)
    message(NOTICE "haptogram: missing: ${names}. On Debian 12 tools/setup installs all of it; elsewhere install it by the system's own means. CONTRIBUTING.md says which parts can be left out.")
    message(FATAL_ERROR "Something that Haptogram needs is missing; the line above names it.")
  endif()
endfunction()

# The same for what pkg-config knows, as PkgConfig::NAME: haptogram_need_module(NAME PACKAGE MODULES...)
macro(haptogram_need_module name package)
  if(PkgConfig_FOUND)
    pkg_check_modules(${name} QUIET IMPORTED_TARGET ${ARGN})
  endif()
  if(NOT ${name}_FOUND)
    list(APPEND HAPTOGRAM_MISSING "${ARGN} (${package})")
  endif()
  string(APPEND HAPTOGRAM_MODULES "set(haptogram_modules_${name} ${ARGN})\nset(haptogram_package_${name} ${package})\n")
endmacro()
