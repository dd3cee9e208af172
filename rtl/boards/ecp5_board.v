// SPDX-License-Identifier: Apache-2.0
//
// The top of every board with an ECP5: 25 MHz in, 50 MHz from the PLL, reset, LED and pins around the core.
//
// tools/bitstream.py sets the parameters to the configuration that the board's file in constraints/ names. It also defines
// HG_LED when the board has an LED, and HG_HIGH as the number of pins that must be held high for the rest of the board to work.
`default_nettype none
`include "interface.vh"
module ecp5_board #(
    parameter CHANNELS        = `HG_DEFAULT_CHANNELS,
    parameter RECORDS         = `HG_DEFAULT_RECORDS,
    parameter SEQUENCE_DEPTH  = `HG_DEFAULT_SEQUENCE_DEPTH,
    parameter LIVE_DEPTH      = `HG_DEFAULT_LIVE_DEPTH,
    parameter TIMING_BITS     = `HG_DEFAULT_TIMING_BITS,
    parameter PULSE_BITS      = `HG_DEFAULT_PULSE_BITS,
    parameter CLOCK_HZ        = `HG_DEFAULT_CLOCK_HZ,
    parameter BAUD            = `HG_DEFAULT_BAUD,
    parameter WATCHDOG_MS     = `HG_DEFAULT_WATCHDOG_MS,
    parameter MAX_HIGH_CLOCKS = `HG_DEFAULT_MAX_HIGH_CLOCKS,
    parameter PRIMARY_FILE    = "",
    parameter SEQUENCE_FILE   = ""
) (
    input  wire                i_clk,
    input  wire                i_rx,
    output wire                o_tx,
`ifdef HG_LED
    output wire                o_led,
`endif
`ifdef HG_HIGH
    output wire [`HG_HIGH-1:0] o_high,
`endif
    output wire [CHANNELS-1:0] o_pins
);
    wire clk, locked, rst, playing, fault, cycle_start, led;
    ecp5_50mhz pll (.i_clk(i_clk), .clk(clk), .o_locked(locked));
    power_on start (.clk(clk), .i_locked(locked), .rst(rst));

    haptogram_core #(
        .CHANNELS(CHANNELS), .RECORDS(RECORDS), .SEQUENCE_DEPTH(SEQUENCE_DEPTH), .LIVE_DEPTH(LIVE_DEPTH), .TIMING_BITS(TIMING_BITS),
        .PULSE_BITS(PULSE_BITS), .CLOCK_HZ(CLOCK_HZ), .BAUD(BAUD), .WATCHDOG_MS(WATCHDOG_MS), .MAX_HIGH_CLOCKS(MAX_HIGH_CLOCKS),
        .PRIMARY_FILE(PRIMARY_FILE), .SEQUENCE_FILE(SEQUENCE_FILE)
    ) core (
        .clk(clk), .rst(rst), .i_rx(i_rx), .o_tx(o_tx), .o_pins(o_pins), .o_enabled(), .o_playing(playing), .o_fault(fault),
        .o_index(), .o_cycle_start(cycle_start));
    status_led status (
        .clk(clk), .rst(rst), .i_cycle_start(cycle_start), .i_playing(playing), .i_fault(fault), .o_led(led));
`ifdef HG_LED
    assign o_led = led;
`endif
`ifdef HG_HIGH
    assign o_high = {`HG_HIGH{1'b1}};
`endif
endmodule
`default_nettype wire
