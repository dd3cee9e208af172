// SPDX-License-Identifier: Apache-2.0
// What pulse_generators promises, said another way than the module does it: a tick that starts a pulse marks the next ticks in which
// the pin must be high. Overlapping pulses then merge by themselves, as an OR of marks.
localparam F_TICKS = (1 << PULSE_BITS) - 1;  // the longest pulse
localparam [15:0] F_CHANNELS = CHANNELS[15:0];
`ifdef FORMAL_PULSE_GENERATORS
localparam F_BITS = 6;  // of a tick's number
`else
localparam F_BITS = 26;
`endif
localparam [F_BITS-1:0] F_NEVER = {{(F_BITS-TIMING_BITS){1'b0}}, NEVER};
reg f_reset_seen_q, f_off_q;
initial f_reset_seen_q = 1'b0;
always @(posedge clk) {f_reset_seen_q, f_off_q} <= {f_reset_seen_q || rst, off};

// The cycle as cycle_controller drives it. f_next_q is the number of the next tick; f_first_q says that it is a record's first.
reg [F_BITS-1:0] f_next_q;
reg              f_first_q;
wire [F_BITS-1:0] f_next = i_cycle_start ? {F_BITS{1'b0}} : f_next_q;
// About the tick that the channels compare with: its number, its record's pulse length, and the length of the last cycle if there
// was one. f_tick_q is high in the clock in which they compare.
reg [F_BITS-1:0]     f_count_q, f_length_q;
reg [PULSE_BITS-1:0] f_pulse_length_q;
reg                  f_repeats_q, f_tick_q, f_known_q;
initial f_known_q = 1'b0;
always @(posedge clk) begin
    f_tick_q <= i_tick;
    if (i_tick) begin
        {f_next_q, f_count_q, f_pulse_length_q} <= {f_next + 1'b1, f_next, i_pulse_length};
        f_known_q <= f_reset_seen_q;
    end
    if (i_cycle_start) {f_first_q, f_repeats_q} <= {1'b0, !f_first_q};
    if (i_cycle_start && !f_first_q) f_length_q <= f_next_q;
    if (rst || i_commit) f_first_q <= 1'b1;
    if (rst) {f_next_q, f_known_q} <= {{F_BITS{1'b0}}, 1'b0};  // known again from the first tick on
`ifdef FORMAL_PULSE_GENERATORS
`define F_EXPECT assume
`else
`define F_EXPECT assert
`endif
    if (f_reset_seen_q) begin `F_EXPECT (commit_q || $past(rst) || i_pulse_length == $past(i_pulse_length)); end
    if (f_reset_seen_q && $past(rst)) begin `F_EXPECT (i_pulse_length == NONE); end
    if (f_reset_seen_q && !rst) begin
        `F_EXPECT (!i_cycle_start || i_tick);
        `F_EXPECT (f_next_q <= {1'b0, {(F_BITS-1){1'b1}}});
        `F_EXPECT (!commit_q || i_cycle_start);
        `F_EXPECT (!i_tick || !f_first_q || i_cycle_start);
        `F_EXPECT (!i_commit || (o_settled && (!f_first_q || i_cycle_start)));
        // A cycle is whole before the next record is committed, unless outputs are off.
        if (i_commit && i_allow) begin `F_EXPECT ({{(F_BITS-PULSE_BITS){1'b0}}, i_pulse_length} < f_next + {{(F_BITS-1){1'b0}}, i_tick}); end
        else if (i_cycle_start && !f_first_q) begin `F_EXPECT ({{(F_BITS-PULSE_BITS){1'b0}}, i_pulse_length} < f_next_q); end
        if (f_repeats_q && !f_first_q && i_tick) begin `F_EXPECT (i_cycle_start ? f_next_q == f_length_q : f_next_q < f_length_q); end
        `F_EXPECT (!i_shift || (old_left_q == NONE && !commit_q));
        if (i_tick) begin
            `F_EXPECT (i_count == f_next[TIMING_BITS-1:0]);
            `F_EXPECT (i_can_match == (i_pulse_length != NONE && f_next < F_NEVER));
        end
    end
end
`undef F_EXPECT

// What fall_q and lead_q must therefore be.
wire [F_BITS-1:0] f_pulse_length = {{(F_BITS-PULSE_BITS){1'b0}}, f_pulse_length_q};
wire              f_leads = f_count_q < f_pulse_length;
wire [F_BITS-1:0] f_fall  = !f_leads ? f_count_q - f_pulse_length : f_repeats_q ? f_length_q + f_count_q - f_pulse_length : F_NEVER;
always @(posedge clk) assert (f_reset_seen_q ? f_known_q || (f_first_q && i_pulse_length == NONE) : !f_known_q);
always @(posedge clk) if (f_known_q) begin
    assert (f_pulse_length_q == NONE || fall_q == (f_fall > F_NEVER ? NEVER : f_fall[TIMING_BITS-1:0]));
    assert (lead_q == (f_leads ? f_pulse_length_q - f_count_q[PULSE_BITS-1:0] : NONE) && count_q == f_count_q[TIMING_BITS-1:0]);
    assert (!start_q || (f_tick_q && f_pulse_length_q != NONE && f_count_q < F_NEVER));
    assert (moves_q == (f_tick_q || commit_q) && (!f_first_q || commit_q) && !f_count_q[F_BITS-1]);
    assert (f_pulse_length_q == NONE || !f_repeats_q || (f_length_q > f_pulse_length && f_count_q < f_length_q));
    assert (f_first_q || (f_next_q == f_count_q + 1'b1 && f_pulse_length_q == i_pulse_length));
    cover (f_repeats_q && f_count_q == {F_BITS{1'b0}} && f_pulse_length_q == ONE + ONE && !f_off_q);
end

// Ticks since the last commit, and whether in the last of them a gap was to be filled: as long as the pulses before it could last.
reg [F_BITS-1:0]     f_since_q;
reg [PULSE_BITS-1:0] f_old_length_q;
reg                  f_filled_q;
localparam [F_BITS-1:0] F_NONE = {F_BITS{1'b1}};
wire [F_BITS-1:0]    f_old_length = {{(F_BITS-PULSE_BITS){1'b0}}, f_old_length_q};
wire [F_BITS-1:0]    f_gone = f_since_q + {{(F_BITS-1){1'b0}}, tick_q && !commit_q};  // ticks, with the one in this clock
wire                 f_fills = f_since_q != F_NONE && (commit_q || f_since_q < 2 || f_since_q <= f_old_length);
always @(posedge clk) begin
    if (rst) f_since_q <= F_NONE;
    else if (i_commit) {f_since_q, f_old_length_q} <= {{F_BITS{1'b0}}, i_pulse_length};
    else if (off) f_since_q <= F_NONE;  // such pulses are cut
    else if (tick_q && !commit_q && f_since_q < F_NONE - 1'b1) f_since_q <= f_since_q + 1'b1;
    if (f_reset_seen_q) assert (fills_q == f_fills);
    if (f_reset_seen_q && f_since_q == F_NONE) assert (old_left_q == NONE && !ending_q);
    if (f_reset_seen_q && f_since_q != F_NONE) begin
        assert (ending_q == (f_since_q < 1 || f_since_q < f_old_length));
        assert (old_left_q == (f_gone < f_old_length ? f_old_length_q - f_gone[PULSE_BITS-1:0] : NONE));
    end
    if (f_tick_q) f_filled_q <= f_fills;
end

// Follows any one word through the chain: f_word_q was shifted in f_age_q shifts ago; 0 means that no word is followed.
reg [TIMING_BITS-1:0] f_word_q;
reg [15:0]            f_age_q;
`ifdef FORMAL_PULSE_GENERATORS
(* anyseq *) wire f_watch;
`else
wire f_watch = f_age_q == 16'd0;
`endif
always @(posedge clk) begin
    if (rst) f_age_q <= 16'd0;
    else if (i_shift && f_watch) {f_word_q, f_age_q} <= {i_timing, 16'd1};
    else if (commit_q) f_age_q <= 16'd0;
    else if (i_shift && f_age_q != 16'd0) f_age_q <= f_age_q == F_CHANNELS ? 16'd0 : f_age_q + 1'b1;
    if (f_reset_seen_q) assert (f_age_q <= F_CHANNELS);
end

// With a bit for each of 255 ticks this takes more than half of the time of a simulated core, whose pins its tests compare with the
// reference board's; there it is left out.
`ifndef FORMAL_WHOLE_CORE
genvar f_k;
generate
    for (f_k = 0; f_k < CHANNELS; f_k = f_k + 1) begin : f_channel
        wire [TIMING_BITS-1:0] f_timing = timings_q[f_k*TIMING_BITS +: TIMING_BITS];
        // Bit j: the pin is high in the j-th tick from now.
        reg [F_TICKS-1:0]     f_future_q;
        reg                   f_last_q, f_before_q;  // the marks of the last tick and of the one before it
        reg                   f_pin_past_q;  // because Yosys does not build $past of a part of a wide vector
        reg [TIMING_BITS-1:0] f_timing_q;
        wire [F_TICKS-1:0]    f_pulse  = ~({F_TICKS{1'b1}} << f_pulse_length_q);
        wire                  f_starts = start_q && count_q == f_timing;
        // The same, computed from fall_q and old_fall_q: how long new_q and old_q stay high.
        wire [F_BITS-1:0]     f_start  = {{(F_BITS-TIMING_BITS){1'b0}}, f_timing};  // its tick, in the cycle's numbers
        wire                  f_ahead  = f_leads && (fall_q == NEVER || f_timing < fall_q);
        wire [F_BITS-1:0]     f_new    = (f_ahead ? {{(F_BITS-PULSE_BITS){1'b0}}, lead_q} + f_start
                                                  : f_start - {{(F_BITS-TIMING_BITS){1'b0}}, fall_q}) + {{(F_BITS-1){1'b0}}, f_tick_q};
        wire [PULSE_BITS-1:0] f_old    = shadow_q[f_k*TIMING_BITS +: PULSE_BITS] - old_fall_q;
        wire [PULSE_BITS:0]   f_old_left = {1'b0, f_old} + {{PULSE_BITS{1'b0}}, f_tick_q};
        wire [F_TICKS-1:0]    f_left   = (new_q[f_k] ? ~({F_TICKS{1'b1}} << f_new) : {F_TICKS{1'b0}})
                                       | (old_q[f_k] ? ~({F_TICKS{1'b1}} << f_old_left) : {F_TICKS{1'b0}});
        always @(posedge clk) begin
            {f_pin_past_q, f_timing_q} <= {o_pins[f_k], f_timing};
            if (off) f_future_q <= {F_TICKS{1'b0}};
            else if (f_tick_q) f_future_q <= (f_future_q >> 1) | (f_starts ? f_pulse : {F_TICKS{1'b0}});
            if (off) {f_last_q, f_before_q} <= 2'b00;
            else if (f_tick_q) {f_last_q, f_before_q} <= {f_future_q[0], f_last_q};
            if (f_reset_seen_q) begin
                // A tick late, and high where only this tick is unmarked, if a pulse from before a change has just ended.
                assert (o_pins[f_k] == (f_last_q || (f_before_q && f_future_q[0] && f_filled_q)));
                assert (f_future_q == f_left);
                assert (!new_q[f_k] || (f_known_q && f_timing != NEVER && f_new != {F_BITS{1'b0}} && f_new <= f_pulse_length));
                assert (!new_q[f_k] || (f_ahead ? f_start + {{(F_BITS-1){1'b0}}, f_tick_q} <= f_count_q : f_start >= f_fall));
                assert (!new_q[f_k] || f_ahead || (f_leads ? f_start < f_length_q : f_start + {{(F_BITS-1){1'b0}}, f_tick_q} <= f_count_q));
                assert (!old_q[f_k] || (f_known_q && f_old_left != {(PULSE_BITS+1){1'b0}}));
                assert (!old_q[f_k] || (commit_q ? f_tick_q && f_old == NONE : f_old_left <= {1'b0, old_left_q} + {{PULSE_BITS{1'b0}}, f_tick_q}));
                if (f_age_q == F_CHANNELS - f_k) assert (shadow_q[f_k*TIMING_BITS +: TIMING_BITS] == f_word_q);
                if ($past(f_reset_seen_q && commit_q) && $past(f_age_q) == F_CHANNELS - f_k) assert (f_timing == $past(f_word_q));
                if (!$past(commit_q)) assert (f_timing == f_timing_q);
                cover (o_pins[f_k] && !f_last_q);
                cover (f_starts && !off && f_future_q[1] && !f_future_q[2] && f_pulse[2]);  // merges
                cover (f_starts && !off && f_future_q[2] && !f_pulse[1]);  // within another
                cover (!o_pins[f_k] && f_pin_past_q && !f_off_q);
                cover ($past(commit_q) && $past(f_age_q) == F_CHANNELS - f_k);
            end
        end
    end
endgenerate
`endif
