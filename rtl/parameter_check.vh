// Generated from tools/interface.toml by tools/generate_interface.py; edit the table, not this file.
// SPDX-License-Identifier: Apache-2.0
generate if (CHANNELS < 2 || CHANNELS > 1000) channels_out_of_range error(); endgenerate
generate if (RECORDS < 1 || RECORDS > 65534) records_out_of_range error(); endgenerate
generate if (SEQUENCE_DEPTH < 2 || SEQUENCE_DEPTH > 32767) sequence_depth_out_of_range error(); endgenerate
generate if (LIVE_DEPTH < 4 || LIVE_DEPTH > 32768 || (LIVE_DEPTH & (LIVE_DEPTH - 1)) != 0) live_depth_out_of_range error(); endgenerate
generate if (TIMING_BITS < 4 || TIMING_BITS > 16) timing_bits_out_of_range error(); endgenerate
generate if (PULSE_BITS < 1 || PULSE_BITS > 8 || PULSE_BITS > TIMING_BITS) pulse_bits_out_of_range error(); endgenerate
generate if (CLOCK_HZ < 1000000 || CLOCK_HZ > 1000000000) clock_hz_out_of_range error(); endgenerate
generate if (BAUD < 1 || BAUD > 125000000 || BAUD < CLOCK_HZ / 20000 || BAUD > CLOCK_HZ / 8) baud_out_of_range error(); endgenerate
generate if (WATCHDOG_MS < 0 || WATCHDOG_MS > 65535) watchdog_ms_out_of_range error(); endgenerate
generate if (MAX_HIGH_CLOCKS < 64 || MAX_HIGH_CLOCKS > 16777215) max_high_clocks_out_of_range error(); endgenerate
generate if (MIN_PULSE_CLOCKS < 1 || MIN_PULSE_CLOCKS > 65535 || MIN_PULSE_CLOCKS > MAX_HIGH_CLOCKS / 10) min_pulse_clocks_out_of_range error(); endgenerate
generate if (MAX_DUTY_256 < 1 || MAX_DUTY_256 > 255) max_duty_256_out_of_range error(); endgenerate
generate if (WIDTH_BITS != 0 && (WIDTH_BITS < 6 || WIDTH_BITS > 16 || WIDTH_BITS < PULSE_BITS || WIDTH_BITS > TIMING_BITS)) width_bits_out_of_range error(); endgenerate
generate if (MODULATION_DEPTH != 0 && (MODULATION_DEPTH < 4 || MODULATION_DEPTH > 65536 || (MODULATION_DEPTH & (MODULATION_DEPTH - 1)) != 0 || WIDTH_BITS == 0)) modulation_depth_out_of_range error(); endgenerate
generate if (SLEW < 0 || SLEW > 1 || (SLEW != 0 && WIDTH_BITS == 0)) slew_out_of_range error(); endgenerate
generate if (FOCI != 0 && (FOCI < 8 || FOCI > 8 || WIDTH_BITS == 0)) foci_out_of_range error(); endgenerate
generate if (SCHEDULE < 0 || SCHEDULE > 1) schedule_out_of_range error(); endgenerate
generate if (SYNC < 0 || SYNC > 1) sync_out_of_range error(); endgenerate
generate if (CHAIN < 0 || CHAIN > 1) chain_out_of_range error(); endgenerate
generate if (NET < 0 || NET > 1) net_out_of_range error(); endgenerate
generate if (STREAM != 0 && (STREAM < 4 || STREAM > 1024 || (STREAM & (STREAM - 1)) != 0 || SCHEDULE == 0 || WIDTH_BITS == 0)) stream_out_of_range error(); endgenerate
generate if (TRIGGER < 0 || TRIGGER > 1 || (TRIGGER != 0 && SCHEDULE == 0)) trigger_out_of_range error(); endgenerate
generate if (SDRAM != 0 && (SDRAM < 4 || SDRAM > 8 || (SDRAM & (SDRAM - 1)) != 0)) sdram_out_of_range error(); endgenerate
