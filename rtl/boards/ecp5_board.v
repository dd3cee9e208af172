// SPDX-License-Identifier: Apache-2.0
//
// The boards with an ECP5: 25 MHz in, 50 MHz from the PLL. The parameters, and whether there is an LED (HG_LED) or pins to be
// held high (HG_HIGH, their number), come from the board's file in constraints/ through tools/bitstream.py.
`default_nettype none
module ecp5_board #(
    parameter CHANNELS        = 56,
    parameter RECORDS         = 400,
    parameter SEQUENCE_DEPTH  = 1024,
    parameter LIVE_DEPTH      = 256,
    parameter TIMING_BITS     = 16,
    parameter PULSE_BITS      = 8,
    parameter CLOCK_HZ        = 50000000,
    parameter BAUD            = 115200,
    parameter WATCHDOG_MS     = 500,
    parameter MAX_HIGH_CLOCKS = 10000,
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
