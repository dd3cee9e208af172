// SPDX-License-Identifier: Apache-2.0
//
// The top of the Lattice iCE40HX8K-B-EVN: 12 MHz in, 48 MHz from the PLL, reset, LED and pins around the core. With HG_ACTIVE_LOW a
// transducer's driver is on while its pin is low. The chip has no second clock that could watch this one: the LED's pin changes all
// the time, for a monostable beside the board.
//
// tools/bitstream.py sets the parameters to the configuration that constraints/ice40-hx8k-breakout.toml names.
`default_nettype none
module ice40_hx8k_breakout #(
    `include "parameters.vh"
    parameter PRIMARY_FILE = "",
    parameter SEQUENCE_FILE = ""
) (
    input  wire                i_clk,
    input  wire                i_rx,
    input  wire                i_stop,           // pulled up: outputs are off while it is low
    output wire                o_tx,
    output wire                o_driver_enable,  // high while outputs are on
    output wire                o_led,
    output wire [CHANNELS-1:0] o_pins
);
    wire clk, locked, rst, alive, playing, fault, cycle_start;
    wire [CHANNELS-1:0] pins;
    // 12 MHz · (63 + 1) / 2^4 = 48 MHz; the oscillator at 768 MHz
    SB_PLL40_CORE #(
        .FEEDBACK_PATH("SIMPLE"), .DIVR(4'd0), .DIVF(7'd63), .DIVQ(3'd4), .FILTER_RANGE(3'd1)
    ) pll (
        .REFERENCECLK(i_clk), .RESETB(1'b1), .BYPASS(1'b0), .PLLOUTGLOBAL(clk), .LOCK(locked));
    power_on start (.clk(clk), .i_locked(locked), .rst(rst));

    haptogram_core #(
        `include "parameter_connections.vh"
        .PRIMARY_FILE(PRIMARY_FILE), .SEQUENCE_FILE(SEQUENCE_FILE)
    ) core (
        .clk(clk), .rst(rst), .i_rx(i_rx), .i_stop(!i_stop), .i_sync(1'b0), .o_sync(), .i_trigger(1'b0), .o_trigger(), .o_test(), .o_tx(o_tx), .i_next(1'b1), .o_next(),
        .i_net_valid(1'b0), .i_net_byte(8'd0), .i_net_old(3'd0), .i_net_lost(1'b0), .i_net_end(1'b0), .i_net_off(1'b0), .i_net_stop(1'b0), .o_net_off(), .o_net_valid(), .i_net_ready(1'b0), .o_net_byte(), .i_identity_place(5'd0), .o_identity_word(),
        .o_sdram_command(), .o_sdram_bank(), .o_sdram_address(), .o_sdram_data(), .o_sdram_drive(), .i_sdram_data(32'd0), .o_flash_cs_n(), .o_flash_clk(), .o_flash_data(), .i_flash_data(1'b1),
        .o_pins(pins), .o_enabled(o_driver_enable), .o_alive(alive),
        .o_playing(playing), .o_fault(fault), .o_index(), .o_cycle_start(cycle_start));
    // The registers in the I/O cells: all pins change within the same nanosecond, wherever their channels were placed.
    genvar k;
    generate
        for (k = 0; k < CHANNELS; k = k + 1) begin : pin
            SB_IO #(.PIN_TYPE(6'b0101_01)) io (.PACKAGE_PIN(o_pins[k]), .OUTPUT_CLK(clk), .D_OUT_0(
`ifdef HG_ACTIVE_LOW
                !pins[k]
`else
                pins[k]
`endif
            ));
        end
    endgenerate
    status_led status (
        .clk(clk), .rst(rst), .i_alive(alive), .i_cycle_start(cycle_start), .i_playing(playing), .i_fault(fault), .o_led(o_led));
endmodule
`default_nettype wire
