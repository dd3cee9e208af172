# SPDX-License-Identifier: Apache-2.0
# The configurations of the core (tools/interface.toml) that are Verilated; HAPTOGRAM_MODELS names fewer, and the tests need all. An image
# runs on the first one with its clock and channels, and enough of all else.
include(${CMAKE_CURRENT_LIST_DIR}/configurations.cmake)
if(NOT DEFINED HAPTOGRAM_MODELS)  # not in the cache, which would keep an older list than this
  set(HAPTOGRAM_MODELS tile-100 small-16 small-16-sync hoshi-324 small-16-wide tile-100-wide tile-100-sync unit-36 amplitudes-256
    small-16-net colorlight-5a-75e-v7.1-net colorlight-5a-75e-v7.1-sdram)
endif()
# Further options of Verilator for a model. The small cores, on which most contract tests run, check in every clock what the
# proofs assert.
set(HAPTOGRAM_MODEL_OPTIONS_small-16 --assert -DFORMAL -DFORMAL_WHOLE_CORE)
set(HAPTOGRAM_MODEL_OPTIONS_small-16-wide --assert -DFORMAL -DFORMAL_WHOLE_CORE)
