// SPDX-License-Identifier: Apache-2.0
//
// The top of every board with an ECP5: 25 MHz in, 50 MHz from the PLL, reset, LED and pins around the core.
//
// tools/bitstream.py sets the parameters to the configuration that the board's file in constraints/ names. It also defines
// HG_LED when the board has an LED, HG_HIGH as the number of pins that must be held high for the rest of the board to work, and:
//   HG_STOP           the level of the stop input at which outputs are off, 0 or 1, when the board has one
//   HG_DRIVER_ENABLE  the level, 0 or 1, at which the drivers are on, when it has a pin for their enable input: they are while
//                     outputs are enabled and the clock runs
//   HG_SYNC_IN, HG_SYNC_OUT  when it has a pin for SYNC from a master, or to slaves
//   HG_CHAIN          when it has two for the serial line of the next tile
//   HG_ALIVE          when it has a pin that changes as long as there is a clock
//   HG_ACTIVE_LOW     when a transducer's driver is on while its pin is low
// The enable is taken away by clock_watch, which has a clock of its own, when this one stops.
`default_nettype none
module ecp5_board #(
    `include "parameters.vh"
    parameter PRIMARY_FILE = "",
    parameter SEQUENCE_FILE = ""
) (
    input  wire                i_clk,
    input  wire                i_rx,
`ifdef HG_STOP
    input  wire                i_stop,
`endif
`ifdef HG_SYNC_IN
    input  wire                i_sync,
`endif
`ifdef HG_SYNC_OUT
    output wire                o_sync,
`endif
    output wire                o_tx,
`ifdef HG_CHAIN
    input  wire                i_next,
    output wire                o_next,
`endif
`ifdef HG_DRIVER_ENABLE
    output wire                o_driver_enable,
`endif
`ifdef HG_ALIVE
    output wire                o_alive,
`endif
`ifdef HG_LED
    output wire                o_led,
`endif
`ifdef HG_HIGH
    output wire [`HG_HIGH-1:0] o_high,
`endif
    output wire [CHANNELS-1:0] o_pins
);
`ifdef HG_STOP
    wire stop = i_stop == 1'b`HG_STOP;
`else
    wire stop = 1'b0;
`endif
`ifdef HG_SYNC_IN
    wire sync_in = i_sync;
`else
    wire sync_in = 1'b0;
`endif
`ifdef HG_CHAIN
    wire next_in = i_next;
`else
    wire next_in = 1'b1;
`endif
    wire sync_out, next_out;
`ifdef HG_CHAIN
    assign o_next = next_out;
`endif
`ifdef HG_SYNC_OUT
    assign o_sync = sync_out;
`endif
    wire clk, locked, starting, enabled, alive, running, playing, fault, cycle_start, led;
    wire [CHANNELS-1:0] pins;
    ecp5_50mhz pll (.i_clk(i_clk), .clk(clk), .o_locked(locked));
    power_on start (.clk(clk), .i_locked(locked), .rst(starting));
    // A register of its own: the way to all that is reset is the longest there is.
    reg rst;
    initial rst = 1'b1;
    always @(posedge clk) rst <= starting;

    haptogram_core #(
        `include "parameter_connections.vh"
        .PRIMARY_FILE(PRIMARY_FILE), .SEQUENCE_FILE(SEQUENCE_FILE)
    ) core (
        .clk(clk), .rst(rst), .i_rx(i_rx), .i_stop(stop), .i_sync(sync_in), .o_sync(sync_out), .o_tx(o_tx), .i_next(next_in), .o_next(next_out), .o_pins(pins), .o_enabled(enabled), .o_alive(alive),
        .o_playing(playing), .o_fault(fault), .o_index(), .o_cycle_start(cycle_start));
    clock_watch watch (.i_alive(alive), .o_running(running));
`ifdef HG_DRIVER_ENABLE
    assign o_driver_enable = (enabled && running) == 1'b`HG_DRIVER_ENABLE;
`endif
`ifdef HG_ALIVE
    assign o_alive = alive;
`endif
`ifdef HG_ACTIVE_LOW
    assign o_pins = ~pins;
`else
    assign o_pins = pins;
`endif
    status_led status (
        .clk(clk), .rst(rst), .i_alive(alive), .i_cycle_start(cycle_start), .i_playing(playing), .i_fault(fault), .o_led(led));
`ifdef HG_LED
    assign o_led = led;
`endif
`ifdef HG_HIGH
    assign o_high = {`HG_HIGH{1'b1}};
`endif
endmodule
`default_nettype wire
