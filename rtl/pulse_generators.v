// SPDX-License-Identifier: Apache-2.0
//
// One pulse generator per transducer and the register before its pin: high for i_pulse_length ticks, once per cycle, from
// the tick that equals the channel's timing.
//
// A pulse that has started always completes, whatever is loaded meanwhile, so a change of focus can neither cut a pulse
// short nor lose one; a pulse that starts inside another one extends it (they merge). While i_allow is low the pins are
// low, from the next clock on, and nothing starts, so the first pulse after enabling is whole. Latency: a pin follows the
// matching tick by two clocks. Timings arrive through shadow registers in one chain, fed at the last channel's end: after
// CHANNELS shifts the first is at channel 0; i_commit copies all of them into the compared registers on one clock edge.
// TIMING_BITS 4…16, PULSE_BITS 1…8.
`default_nettype none
module pulse_generators #(
    parameter CHANNELS    = 100,
    parameter TIMING_BITS = 16,
    parameter PULSE_BITS  = 8
) (
    input  wire                   clk,
    input  wire                   rst,
    input  wire                   i_allow,         // from output_guard
    input  wire                   i_shift,
    input  wire [TIMING_BITS-1:0] i_timing,
    input  wire                   i_commit,
    input  wire                   i_tick,          // one clock, at the start of each tick
    input  wire                   i_can_match,     // pulses are wanted and the count fits TIMING_BITS
    input  wire [TIMING_BITS-1:0] i_count,
    input  wire [PULSE_BITS-1:0]  i_pulse_length,  // ticks, > 0 while i_can_match
    output reg  [CHANNELS-1:0]    o_pins
);
    localparam [PULSE_BITS-1:0] NONE = {PULSE_BITS{1'b0}};

    // Pins change only in the clock after a tick; saying so spares a simulator most of its work.
    reg tick_q;
    always @(posedge clk) tick_q <= i_tick;

    reg [CHANNELS*TIMING_BITS-1:0] shadow_q;
    reg [CHANNELS*TIMING_BITS-1:0] timings_q;
    always @(posedge clk) if (i_commit) timings_q <= shadow_q;
    always @(posedge clk) if (i_shift) shadow_q <= {i_timing, shadow_q[CHANNELS*TIMING_BITS-1:TIMING_BITS]};

`ifdef FORMAL
    localparam F_TICKS = (1 << PULSE_BITS) - 1;  // the longest pulse
    localparam [15:0] F_CHANNELS = CHANNELS[15:0];
    wire f_off = rst || !i_allow;
    reg  f_reset_seen_q, f_off_q;
    initial f_reset_seen_q = 1'b0;
    always @(posedge clk) {f_reset_seen_q, f_off_q} <= {f_reset_seen_q || rst, f_off};

    // Any one word on its way through the chain: f_word_q was shifted in f_age_q shifts ago (0: none is watched).
`ifdef FORMAL_PULSE_GENERATORS
    (* anyseq *) wire f_watch;
`else
    wire f_watch = f_age_q == 16'd0;
`endif
    reg [TIMING_BITS-1:0] f_word_q;
    reg [15:0]            f_age_q;
    always @(posedge clk) begin
        if (rst) f_age_q <= 16'd0;
        else if (i_shift && f_watch) {f_word_q, f_age_q} <= {i_timing, 16'd1};
        else if (i_shift && f_age_q != 16'd0) f_age_q <= f_age_q == F_CHANNELS ? 16'd0 : f_age_q + 1'b1;
        if (f_reset_seen_q) assert (f_age_q <= F_CHANNELS);
    end
`endif

    genvar k;
    generate
        for (k = 0; k < CHANNELS; k = k + 1) begin : channel
            wire [TIMING_BITS-1:0] timing = timings_q[k*TIMING_BITS +: TIMING_BITS];
            reg [PULSE_BITS-1:0]   left_q;  // ticks still to be high

            initial o_pins[k] = 1'b0;
            initial left_q = NONE;
            always @(posedge clk) begin
                if (rst || !i_allow) o_pins[k] <= 1'b0;
                else if (tick_q) o_pins[k] <= left_q != NONE;

                if (rst || !i_allow || i_tick)
                    left_q <= rst || !i_allow ? NONE
                            // The longer of the old pulse's rest and the new pulse: their union in time.
                            : i_can_match && i_count == timing && i_pulse_length >= left_q ? i_pulse_length
                            : left_q != NONE ? left_q - 1'b1 : NONE;
            end

`ifdef FORMAL
            // Bit j: high in the j-th tick from here. So the union of pulses is an or, and there is nothing to compare.
            reg [F_TICKS-1:0]  f_future_q;
            reg                f_high_q, f_pin_q;  // one clock ago; Verilator cannot build $past of a wide vector's part
            reg [TIMING_BITS-1:0] f_timing_q;
            wire [F_TICKS-1:0] f_pulse  = ~({F_TICKS{1'b1}} << i_pulse_length);
            wire               f_starts = i_tick && i_can_match && i_count == timing;
            always @(posedge clk) begin
                {f_high_q, f_pin_q, f_timing_q} <= {f_future_q[0], o_pins[k], timing};
                if (f_off) f_future_q <= {F_TICKS{1'b0}};
                else if (i_tick) f_future_q <= (f_future_q >> 1) | (f_starts ? f_pulse : {F_TICKS{1'b0}});
                if (f_reset_seen_q) begin
                    assert (f_future_q == ~({F_TICKS{1'b1}} << left_q));
                    assert (o_pins[k] == (!f_off_q && ($past(tick_q) ? f_high_q : f_pin_q)));
                    if (f_age_q == F_CHANNELS - k) assert (shadow_q[k*TIMING_BITS +: TIMING_BITS] == f_word_q);
                    if ($past(f_reset_seen_q && i_commit) && $past(f_age_q) == F_CHANNELS - k) assert (timing == $past(f_word_q));
                    if (!$past(i_commit)) assert (timing == f_timing_q);
                    cover (f_starts && !f_off && f_future_q[1] && !f_future_q[2] && f_pulse[2]);  // merges
                    cover (f_starts && !f_off && f_future_q[2] && !f_pulse[1]);  // within another
                    cover (!o_pins[k] && f_pin_q && !f_off_q);
                    cover ($past(i_commit) && $past(f_age_q) == F_CHANNELS - k);
                end
            end
`endif
        end
    endgenerate
endmodule
`default_nettype wire
