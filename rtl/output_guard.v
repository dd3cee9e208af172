// SPDX-License-Identifier: Apache-2.0
//
// Decides whether the pins may be high at all: not from power-up until enabled, nor from the clock after disable, watchdog
// expiry or reset, and no longer than MAX_HIGH_CLOCKS at a time, whatever is in memory. o_allow holds the last
// registers before the pins low one clock later.
//
// The bound: time is cut into windows of MAX_HIGH_CLOCKS / 2 − 1 clocks; a channel that was high through a whole window trips the
// guard, which disables every output until the host enables them again. One bit per channel does it.
`default_nettype none
module output_guard #(
    parameter CHANNELS        = 100,
    parameter MAX_HIGH_CLOCKS = 10000  // even, ≥ 8
) (
    input  wire                clk,
    input  wire                rst,
    input  wire                i_enable,   // strobe
    input  wire                i_disable,  // strobe; wins over i_enable
    input  wire                i_expired,  // strobe from the watchdog; wins over i_enable
    input  wire [CHANNELS-1:0] i_pins,
    output wire                o_allow,
    output reg                 o_enabled,
    output reg                 o_trip      // strobe: some channel was high too long
);
    localparam WINDOW      = MAX_HIGH_CLOCKS / 2 - 1;
    localparam WINDOW_BITS = $clog2(MAX_HIGH_CLOCKS + 1);
    localparam [WINDOW_BITS-1:0] WINDOW_LAST = WINDOW[WINDOW_BITS-1:0] - 1'b1;

    generate
        if (MAX_HIGH_CLOCKS < 8 || MAX_HIGH_CLOCKS >= (1 << 24)) max_high_clocks_out_of_range error();
    endgenerate

    reg [WINDOW_BITS-1:0] window_q;
    reg [CHANNELS-1:0]    stayed_high_q;  // since the window's start
    wire                  window_ends = window_q == WINDOW_LAST;
    wire                  off = rst || i_disable || i_expired || o_trip;

    always @(posedge clk) begin
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
        if (off) o_enabled <= 1'b0;
        else if (i_enable) o_enabled <= 1'b1;
    end
    assign o_allow = o_enabled && !off;

`ifdef FORMAL
    // Proved with pulse_generators as its pins, which is where contract 4 holds as a whole.
    localparam [WINDOW_BITS-1:0] F_WINDOW = WINDOW[WINDOW_BITS-1:0];
    localparam [WINDOW_BITS-1:0] F_BOUND  = MAX_HIGH_CLOCKS[WINDOW_BITS-1:0];
    reg f_past_valid_q, f_reset_seen_q, f_wanted_q, f_any_q, f_off_q;
    initial {f_past_valid_q, f_reset_seen_q, f_wanted_q} = 3'b000;
    always @(posedge clk) begin
        f_past_valid_q <= 1'b1;
        f_off_q        <= rst || i_disable || i_expired || o_trip;
        f_any_q        <= i_pins != {CHANNELS{1'b0}};
        f_reset_seen_q <= f_reset_seen_q || rst;
        // Some strobe enabled the outputs and nothing has disabled them since.
        if (rst || i_disable || i_expired || o_trip) f_wanted_q <= 1'b0;
        else if (i_enable) f_wanted_q <= 1'b1;
        assert (o_enabled == f_wanted_q);
        assert (!o_allow || f_wanted_q);
        if (!f_past_valid_q || !$past(f_wanted_q)) assert (i_pins == {CHANNELS{1'b0}});
        if (f_past_valid_q && f_off_q) assert (i_pins == {CHANNELS{1'b0}});
        if (f_reset_seen_q) assert (window_q < F_WINDOW && (!o_trip || window_q == {WINDOW_BITS{1'b0}}));
        cover (f_reset_seen_q && o_trip);
        cover (f_past_valid_q && i_disable && f_any_q);
    end

    genvar f_k;
    generate
        for (f_k = 0; f_k < CHANNELS; f_k = f_k + 1) begin : f_channel
            reg [WINDOW_BITS-1:0]  f_high_q;  // clocks this pin has been high without a break, until the last one
            wire [WINDOW_BITS-1:0] f_high = i_pins[f_k] ? f_high_q + 1'b1 : {WINDOW_BITS{1'b0}};
            initial f_high_q = {WINDOW_BITS{1'b0}};
            always @(posedge clk) begin
                f_high_q <= f_high;
                if (f_reset_seen_q) begin
                    assert (f_high <= F_BOUND);
                    assert (f_high <= window_q + 1'b1 + (o_trip || stayed_high_q[f_k] ? F_WINDOW : {WINDOW_BITS{1'b0}})
                            + (o_trip ? F_WINDOW : {WINDOW_BITS{1'b0}}));
                    cover (f_high == F_BOUND - 1'b1);
                end
            end
        end
    endgenerate
`endif
endmodule
`default_nettype wire
