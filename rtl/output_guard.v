// SPDX-License-Identifier: Apache-2.0
//
// Decides whether any pin may be high at all. It is the last word on safety, so it trusts nothing that can be loaded.
//
// The pins are low from power-up until the host enables them; low again from the clock after disable or reset;
// and no pin is high for more than MAX_HIGH_CLOCKS at a time, whatever is in memory. o_allow, when low, clears the last
// registers before the pins one clock later.
// How the bound works: time is cut into windows of MAX_HIGH_CLOCKS / 2 − 1 clocks. A channel that was high through a whole
// window trips the guard, which disables every output until the host enables them again. That takes one bit a channel, not a
// counter.
// o_alive is for a retriggerable monostable beside the FPGA: when the clock stops, pins stay as they are, and no logic that needs
// the clock can help.
// CHANNELS is the core's. MAX_HIGH_CLOCKS is even, from 8 to 2^24 − 1: above the longest pulse of the images that are played,
// and below what a transducer and its driver bear.
`default_nettype none
module output_guard #(
    parameter CHANNELS        = 100,
    parameter MAX_HIGH_CLOCKS = 10000
) (
    input  wire                clk,
    input  wire                rst,
    input  wire                i_enable,   // strobe
    input  wire                i_disable,  // wins over i_enable
    input  wire [CHANNELS-1:0] i_pins,
    output wire                o_allow,
    output reg                 o_enabled,
    output reg                 o_trip,     // strobe: some channel was high for too long
    output reg                 o_alive     // changes once a window, as long as there is a clock
);
    localparam WINDOW      = MAX_HIGH_CLOCKS / 2 - 1;
    localparam WINDOW_BITS = $clog2(MAX_HIGH_CLOCKS + 1);
    localparam [WINDOW_BITS-1:0] WINDOW_LAST = WINDOW[WINDOW_BITS-1:0] - 1'b1;

    generate
        if (MAX_HIGH_CLOCKS < 8 || MAX_HIGH_CLOCKS >= (1 << 24)) max_high_clocks_out_of_range error();
    endgenerate

    reg [WINDOW_BITS-1:0] window_q;
    reg [CHANNELS-1:0]    stayed_high_q;  // channels that have been high since the window began
    wire                  window_ends = window_q == WINDOW_LAST;
    wire                  off = i_disable || o_trip;

    initial {o_alive, window_q} = {(WINDOW_BITS+1){1'b0}};
    always @(posedge clk) begin
        o_alive <= !rst && (o_alive ^ window_ends);
        if (rst || window_ends) window_q <= {WINDOW_BITS{1'b0}};
        else window_q <= window_q + 1'b1;
    end

    always @(posedge clk) begin
        if (rst) stayed_high_q <= {CHANNELS{1'b0}};
        else if (window_ends) stayed_high_q <= i_pins;
        else stayed_high_q <= stayed_high_q & i_pins;
    end

    initial o_trip = 1'b0;
    always @(posedge clk) o_trip <= !rst && window_ends && stayed_high_q != {CHANNELS{1'b0}};

    initial o_enabled = 1'b0;
    always @(posedge clk) begin
        if (rst || off) o_enabled <= 1'b0;
        else if (i_enable) o_enabled <= 1'b1;
    end
    assign o_allow = o_enabled && !off;

`ifdef FORMAL
    `include "formal/output_guard.vh"
`endif
endmodule
`default_nettype wire
