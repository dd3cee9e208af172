# SPDX-License-Identifier: Apache-2.0
# The cores that are Verilated: name channels records sequence_depth live_depth timing_bits pulse_bits clock_hz baud
# watchdog_ms max_high_clocks, and options for Verilator, which may be empty: the small core, on which most contract tests run,
# checks in every clock what the proofs assert. An image runs on the first one with its clock and channels, and enough of all else.
set(HAPTOGRAM_MODELS
  "Vtile100:100:400:1024:256:16:8:50000000:1000000:500:10000:"
  "Vsmall16:16:40:64:16:12:8:50000000:3000000:5:4000:--assert -DFORMAL"
  "Varray324:324:400:1024:256:16:8:50000000:1000000:500:10000:")
