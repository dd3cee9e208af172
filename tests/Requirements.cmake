# SPDX-License-Identifier: Apache-2.0
# What the tests need beside what they test; included by the project's CMakeLists.txt.
haptogram_need(Catch2 "catch2, version 2" 2)
haptogram_need_program(yosys yosys)
if(HAPTOGRAM_TESTS)
  if(HAPTOGRAM_SIMULATION AND HAPTOGRAM_FTDI AND PkgConfig_FOUND)
    pkg_check_modules(UMOCKDEV QUIET IMPORTED_TARGET umockdev-1.0)
    if(NOT UMOCKDEV_FOUND)
      list(APPEND HAPTOGRAM_MISSING "umockdev (libumockdev-dev)")
    endif()
    haptogram_need_program(umockdev-wrapper umockdev)
  endif()
  if(HAPTOGRAM_PAGE AND HAPTOGRAM_PROGRAM AND HAPTOGRAM_SIMULATION)
    find_program(HAPTOGRAM_PATH_OF_chromium chromium)  # for `make browser` alone
  endif()
  haptogram_need_program(git git)
  haptogram_need_program(z3 z3)
  haptogram_need_program(iverilog iverilog)
  haptogram_need_program(clang-format clang-format)
  haptogram_need_modules(pytest python3-pytest pytest_timeout python3-pytest-timeout xdist python3-pytest-xdist numpy python3-numpy intelhex python3-intelhex jsonschema python3-jsonschema serial python3-serial
    cobs "PyPI's cobs" pyslang "PyPI's pyslang" setuptools python3-setuptools wheel python3-wheel matplotlib python3-matplotlib
    scipy python3-scipy pandas python3-pandas statsmodels python3-statsmodels)
endif()
if(HAPTOGRAM_TESTS AND HAPTOGRAM_PROGRAM AND HAPTOGRAM_C)
  haptogram_need_modules(nbclient python3-nbclient ipykernel python3-ipykernel distributed "PyPI's distributed" pyarrow "PyPI's pyarrow")
endif()
if(HAPTOGRAM_DEEP_TESTS)
  haptogram_need_program(clang++ clang)
endif()
