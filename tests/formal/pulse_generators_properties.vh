// SPDX-License-Identifier: Apache-2.0
// What pulse_generators promises, told without its falls and halves: every tick that starts a pulse marks the ticks that the
// pulse is to be high for, and the union of pulses is an or of marks. Included by it under FORMAL.
localparam F_TICKS = (1 << PULSE_BITS) - 1;  // the longest pulse
localparam [15:0] F_CHANNELS = CHANNELS[15:0];
`ifdef FORMAL_PULSE_GENERATORS
localparam F_BITS = 6;  // of a tick's number
`else
localparam F_BITS = 24;
`endif
localparam [F_BITS-1:0] F_NEVER = {{(F_BITS-TIMING_BITS){1'b0}}, NEVER};
reg f_reset_seen_q, f_off_q;
initial f_reset_seen_q = 1'b0;
always @(posedge clk) {f_reset_seen_q, f_off_q} <= {f_reset_seen_q || rst, off};

// The cycle as its controller gives it: f_next_q is the number of the next tick, f_first_q before the first one of a record,
// f_length_q the length of its last whole cycle, once there is one.
reg [F_BITS-1:0] f_next_q, f_length_q;
reg        f_first_q, f_repeats_q, f_last_commit_q;
wire [F_BITS-1:0] f_next  = i_cycle_start ? {F_BITS{1'b0}} : f_next_q;
wire [F_BITS-1:0] f_pulse_length = {{(F_BITS-PULSE_BITS){1'b0}}, i_pulse_length};
always @(posedge clk) begin
    f_last_commit_q <= i_commit && !rst;
    if (i_tick) f_next_q <= f_next + 1'b1;
    if (i_cycle_start) {f_first_q, f_repeats_q} <= {1'b0, !f_first_q};
    if (i_cycle_start && !f_first_q) f_length_q <= f_next_q;
    if (rst || i_commit) {f_first_q, f_repeats_q} <= 2'b10;
    if (rst) f_next_q <= {F_BITS{1'b0}};
`ifdef FORMAL_PULSE_GENERATORS
`define F_EXPECT assume
`else
`define F_EXPECT assert
`endif
    if (f_reset_seen_q) begin `F_EXPECT (f_last_commit_q || $past(rst) || i_pulse_length == $past(i_pulse_length)); end
    if (f_reset_seen_q && !rst) begin
        `F_EXPECT (!i_cycle_start || i_tick);
        `F_EXPECT (f_next_q <= {1'b0, {(F_BITS-1){1'b1}}});
        `F_EXPECT (!f_last_commit_q || i_cycle_start);
        `F_EXPECT (!i_tick || !f_first_q || i_cycle_start);
        `F_EXPECT (!i_commit || (o_settled && (!f_first_q || i_cycle_start)));
        if (i_commit) begin `F_EXPECT (f_pulse_length < f_next + {{(F_BITS-1){1'b0}}, i_tick}); end
        else if (i_cycle_start && !f_first_q) begin `F_EXPECT (f_pulse_length < f_next_q); end
        if (f_repeats_q && i_tick) begin `F_EXPECT (i_cycle_start ? f_next_q == f_length_q : f_next_q < f_length_q); end
        if (i_tick) begin
            `F_EXPECT (i_count == f_next[TIMING_BITS-1:0]);
            `F_EXPECT (i_can_match == (i_pulse_length != NONE && f_next < F_NEVER));
        end
    end
end
`undef F_EXPECT

// How the falls follow from it.
wire [F_BITS-1:0] f_fall    = f_next_q >= f_pulse_length ? f_next_q - f_pulse_length : f_repeats_q ? f_length_q + f_next_q - f_pulse_length : F_NEVER;
wire [TIMING_BITS-1:0] f_fall_narrow = f_fall > F_NEVER ? NEVER : f_fall[TIMING_BITS-1:0];
always @(posedge clk) if (f_reset_seen_q) begin
    assert (fall_q == (f_first_q || i_pulse_length == NONE ? NEVER : f_fall_narrow));
    assert (f_first_q || lead_q == (f_next_q < f_pulse_length ? i_pulse_length - f_next_q[PULSE_BITS-1:0] : NONE));
    assert (f_first_q || f_next_q != {F_BITS{1'b0}});
    assert (!f_repeats_q || (!f_first_q && f_length_q > f_pulse_length && f_next_q <= f_length_q));
    cover (f_repeats_q && f_next_q == {{(F_BITS-1){1'b0}}, 1'b1} && i_pulse_length == ONE + ONE && !f_off_q);
end

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

genvar f_k;
generate
    for (f_k = 0; f_k < CHANNELS; f_k = f_k + 1) begin : f_channel
        wire [TIMING_BITS-1:0] f_timing = timings_q[f_k*TIMING_BITS +: TIMING_BITS];
        // Bit j: high in the j-th tick from here. So the union of pulses is an or, and there is nothing to compare.
        reg [F_TICKS-1:0]     f_future_q;
        reg                   f_pin_q, f_pin_past_q;  // as $past of a wide vector's part does not build
        reg [TIMING_BITS-1:0] f_timing_q;
        wire [F_TICKS-1:0]    f_pulse  = ~({F_TICKS{1'b1}} << i_pulse_length);
        // The same from fall_q: what new_q and old_q have left.
        wire                  f_wraps  = fall_q == NEVER || f_timing < fall_q;
        wire [F_BITS-1:0]     f_start  = {{(F_BITS-TIMING_BITS){1'b0}}, f_timing};  // its tick, in the cycle's numbers
        wire [F_BITS-1:0]     f_new    = (f_wraps ? {{(F_BITS-PULSE_BITS){1'b0}}, lead_q} + f_start
                                                  : f_start - {{(F_BITS-TIMING_BITS){1'b0}}, fall_q}) + 1'b1;
        wire [PULSE_BITS-1:0] f_old    = channel[f_k].old_timing_q - old_fall_q;
        wire [F_TICKS-1:0]    f_left   = (channel[f_k].new_q ? ~({F_TICKS{1'b1}} << f_new) : {F_TICKS{1'b0}})
                                       | (channel[f_k].old_q ? ~({F_TICKS{1'b1}} << ({1'b0, f_old} + 1'b1)) : {F_TICKS{1'b0}});
        wire                  f_starts = i_tick && i_can_match && i_count == f_timing;
        always @(posedge clk) begin
            {f_pin_q, f_pin_past_q, f_timing_q} <= {!off && f_future_q[0], o_pins[f_k], f_timing};
            if (off) f_future_q <= {F_TICKS{1'b0}};
            else if (i_tick) f_future_q <= (f_future_q >> 1) | (f_starts ? f_pulse : {F_TICKS{1'b0}});
            if (f_reset_seen_q) begin
                assert (o_pins[f_k] == f_pin_q);
                assert (f_future_q == f_left && (moves_q || o_pins[f_k] == f_future_q[0]));
                assert (!channel[f_k].new_q || (f_timing != NEVER && f_new <= f_pulse_length && !f_first_q));
                assert (!channel[f_k].new_q || f_start < (f_wraps || !f_repeats_q ? f_next_q : f_length_q));
                assert (!channel[f_k].new_q || (f_next_q < f_pulse_length && f_start < f_next_q) || f_start >= f_fall);
                assert (!channel[f_k].old_q || f_old < old_left_q);
                if (f_age_q == F_CHANNELS - f_k) assert (shadow_q[f_k*TIMING_BITS +: TIMING_BITS] == f_word_q);
                if ($past(f_reset_seen_q && i_commit) && $past(f_age_q) == F_CHANNELS - f_k) assert (f_timing == $past(f_word_q));
                if (!$past(i_commit)) assert (f_timing == f_timing_q);
                cover (f_starts && !off && f_future_q[1] && !f_future_q[2] && f_pulse[2]);  // merges
                cover (f_starts && !off && f_future_q[2] && !f_pulse[1]);  // within another
                cover (!o_pins[f_k] && f_pin_past_q && !f_off_q);
                cover ($past(i_commit) && $past(f_age_q) == F_CHANNELS - f_k);
            end
        end
    end
endgenerate
