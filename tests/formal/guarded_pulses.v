// SPDX-License-Identifier: Apache-2.0
//
// Proves contract 4: the guard and the pulse generators are wired as in player; every other signal may take any value.
`default_nettype none
module guarded_pulses #(
    parameter CHANNELS        = 2,
    parameter TIMING_BITS     = 4,
    parameter PULSE_BITS      = 3,
    parameter MAX_HIGH_CLOCKS = 8
) (
    input wire                   clk,
    input wire                   rst,
    input wire                   i_enable,
    input wire                   i_disable,
    input wire                   i_shift,
    input wire [TIMING_BITS-1:0] i_timing,
    input wire                   i_commit,
    input wire                   i_tick,
    input wire                   i_cycle_start,
    input wire                   i_can_match,
    input wire [TIMING_BITS-1:0] i_count,
    input wire [PULSE_BITS-1:0]  i_pulse_length
);
    wire                allow, enabled, trip;
    wire [CHANNELS-1:0] pins;
    pulse_generators #(.CHANNELS(CHANNELS), .TIMING_BITS(TIMING_BITS), .PULSE_BITS(PULSE_BITS)) generators (
        .clk(clk), .rst(rst), .i_allow(allow), .i_shift(i_shift), .i_timing(i_timing), .i_commit(i_commit), .i_tick(i_tick),
        .i_cycle_start(i_cycle_start), .i_can_match(i_can_match), .i_count(i_count), .i_pulse_length(i_pulse_length),
        .o_settled(), .o_pins(pins));
    output_guard #(.CHANNELS(CHANNELS), .MAX_HIGH_CLOCKS(MAX_HIGH_CLOCKS)) guard (
        .clk(clk), .rst(rst), .i_enable(i_enable), .i_disable(i_disable), .i_pins(pins),
        .o_allow(allow), .o_enabled(enabled), .o_trip(trip), .o_alive());
endmodule
`default_nettype wire
