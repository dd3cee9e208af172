// SPDX-License-Identifier: Apache-2.0
// What width_pulse_generators promises, said another way than the module does it: a tick that starts a pulse marks the next ticks in
// which the channel must be high, as many as the pulse is wide. Overlapping pulses then merge by themselves, as an OR of marks. A pin
// is high in a marked tick, and in one between two marked ones.
reg f_reset_seen_q;
initial f_reset_seen_q = 1'b0;
always @(posedge clk) f_reset_seen_q <= f_reset_seen_q || rst;

`ifdef FORMAL_WIDTH_PULSE_GENERATORS
`define F_EXPECT assume
`else
`define F_EXPECT assert
`endif
always @(posedge clk) if (f_reset_seen_q) begin
    `F_EXPECT (commit_q || $past(rst) || i_longest == $past(i_longest));
    `F_EXPECT (!$past(rst) || i_longest == NONE);
    if (!rst) begin
        `F_EXPECT (!commit_q || i_tick);
        `F_EXPECT (!i_commit || o_settled);
        `F_EXPECT (!i_shift || (old_left_q == NONE && !commit_q));
    end
end
`undef F_EXPECT

`ifdef FORMAL_WIDTH_PULSE_GENERATORS
localparam F_TICKS = (1 << WIDTH_BITS) - 1;  // the widest pulse
localparam F_BITS  = TIMING_BITS + 2;        // of a tick's number
localparam [15:0] F_CHANNELS = CHANNELS[15:0];
localparam [F_BITS-1:0] F_NEVER = {2'b00, {TIMING_BITS{1'b1}}}, F_ZERO = 0;
localparam [F_BITS-1:0] F_ONE = 1, F_WRAPS = {2'b01, {TIMING_BITS{1'b0}}};  // the longest cycle over whose end a pulse may run

// The cycle as cycle_controller drives it, of any length, also one longer than the channels can count. f_next_q is the number of the
// next tick, f_count_q that of the tick that the channels compare with.
(* anyseq *) wire [F_BITS-1:0] f_length;
reg [F_BITS-1:0]     f_next_q, f_count_q, f_length_q;
reg [WIDTH_BITS-1:0] f_longest_q;
reg                  f_fresh_q, f_known_q, f_off_q;
initial f_known_q = 1'b0;
wire f_last_tick = f_next_q + F_ONE == f_length;
always @(posedge clk) begin
    assert (f_reset_seen_q || !f_known_q);
    f_off_q   <= off;
    f_fresh_q <= commit_q && !rst;
    if (i_tick) begin
        {f_next_q, f_count_q} <= {f_last_tick ? F_ZERO : f_next_q + F_ONE, f_next_q};
        {f_length_q, f_longest_q} <= {f_length, i_longest};
        f_known_q <= f_reset_seen_q;
    end
    if (rst) {f_next_q, f_known_q} <= {F_ZERO, 1'b0};
    if (f_reset_seen_q && !rst) begin
        assume (commit_q || $past(rst) || f_length == $past(f_length));
        assume (f_length != F_ZERO && !f_length[F_BITS-1]);
        assume ({{(F_BITS-WIDTH_BITS){1'b0}}, i_longest} < f_length);
        assume (!i_commit || (i_tick ? f_last_tick : f_next_q == F_ZERO));
        if (i_tick) begin
            assume (i_count == f_next_q[TIMING_BITS-1:0]);
            assume (i_can_match == (i_longest != NONE && f_next_q < F_NEVER));
        end
    end
    if (f_known_q) begin
        assert (f_count_q < f_length_q && !f_length_q[F_BITS-1] && count_q == f_count_q[TIMING_BITS-1:0]);
        assert (commit_q || f_fresh_q || f_length == f_length_q || rst);
        assert (f_next_q == (f_count_q + F_ONE == f_length_q ? F_ZERO : f_count_q + F_ONE));
        assert ({{(F_BITS-WIDTH_BITS){1'b0}}, f_longest_q} < f_length_q);
        assert (commit_q || (f_length_q == f_length && f_longest_q == i_longest) || rst);
        assert (start_q == (tick_q && f_longest_q != NONE && f_count_q < F_NEVER));
        assert (first_q == (f_fresh_q && f_longest_q != NONE));
        assert (!f_fresh_q || (tick_q && f_count_q == F_ZERO));
        assert (!commit_q || f_next_q == F_ZERO);
    end else if (f_reset_seen_q) assert (!start_q && !first_q && !tick_q && f_next_q == F_ZERO && (commit_q || i_longest == NONE));
end

// Follows any one word through the chain: f_word_q was shifted in f_age_q shifts ago; 0 means that no word is followed.
(* anyseq *) wire f_watch;
reg [WORD-1:0] f_word_q;
reg [15:0]     f_age_q;
always @(posedge clk) begin
    if (rst) f_age_q <= 16'd0;
    else if (i_shift && f_watch) {f_word_q, f_age_q} <= {i_word, 16'd1};
    else if (commit_q) f_age_q <= 16'd0;
    else if (i_shift && f_age_q != 16'd0) f_age_q <= f_age_q == F_CHANNELS ? 16'd0 : f_age_q + 1'b1;
    if (f_reset_seen_q) assert (f_age_q <= F_CHANNELS);
end

(* anyseq *) wire [CHANNELS*WIDTH_BITS-1:0] f_widths;  // of the pulses of the record that is being committed
genvar f_k;
generate
    for (f_k = 0; f_k < CHANNELS; f_k = f_k + 1) begin : f_channel
        // The word that is committed: as the header asks for it.
        wire [WORD-1:0]       f_next_word  = shadow_q[f_k*WORD +: WORD];
        wire                  f_next_early = f_next_word[2*TIMING_BITS];
        wire [F_BITS-1:0]     f_next_rise  = {2'b00, f_next_word[TIMING_BITS +: TIMING_BITS]};
        wire [WIDTH_BITS-1:0] f_next_width = f_widths[f_k*WIDTH_BITS +: WIDTH_BITS];
        wire [F_BITS-1:0]     f_next_stop  = f_next_rise + {{(F_BITS-WIDTH_BITS){1'b0}}, f_next_width};
        wire                  f_next_wraps = f_next_stop >= f_length;
        wire [F_BITS-1:0]     f_next_fall  = f_next_wraps ? f_next_stop - f_length : f_next_stop;
        // The word that is played.
        reg [F_BITS-1:0]      f_rise_q, f_fall_q;
        reg [WIDTH_BITS-1:0]  f_width_q;
        reg                   f_early_q;
        wire                  f_silent = f_rise_q == F_NEVER;
        // Bit j: the channel is high in the j-th tick from now. Then the marks of the ticks before.
        reg [F_TICKS-1:0]     f_future_q;
        reg                   f_mark_1_q, f_mark_2_q, f_pin_past_q;
        wire                  f_starts = tick_q && f_longest_q != NONE && !f_silent && f_count_q == f_rise_q;
        wire                  f_early  = f_fresh_q && f_longest_q != NONE && f_early_q;
        wire [F_TICKS-1:0]    f_marks  = (f_starts ? ~({F_TICKS{1'b1}} << f_width_q) : {F_TICKS{1'b0}})
                                       | (f_early ? ~({F_TICKS{1'b1}} << f_fall_q) : {F_TICKS{1'b0}});
        // The same, computed from fall: how long new_q and old_q stay high.
        wire [F_BITS-1:0]     f_to_fall  = f_fall_q >= f_count_q ? f_fall_q - f_count_q : f_fall_q + f_length_q - f_count_q;
        wire [F_BITS-1:0]     f_new_left = f_to_fall + {{(F_BITS-1){1'b0}}, tick_q};
        wire [WIDTH_BITS-1:0] f_old      = shadow_q[f_k*WORD +: WIDTH_BITS] - old_count_q;
        wire [WIDTH_BITS:0]   f_old_left = {1'b0, f_old} + {{WIDTH_BITS{1'b0}}, tick_q};
        wire [F_TICKS-1:0]    f_left     = (new_q[f_k] ? ~({F_TICKS{1'b1}} << f_new_left) : {F_TICKS{1'b0}})
                                         | (old_q[f_k] ? ~({F_TICKS{1'b1}} << f_old_left) : {F_TICKS{1'b0}});
        wire [F_BITS-1:0]     f_width    = {{(F_BITS-WIDTH_BITS){1'b0}}, f_width_q};
        always @(posedge clk) begin
            f_pin_past_q <= o_pins[f_k];
            if (commit_q) {f_rise_q, f_fall_q, f_width_q, f_early_q} <= {f_next_rise, f_next_fall, f_next_width, f_next_early};
            if (off) {f_future_q, f_mark_1_q, f_mark_2_q} <= {(F_TICKS+2){1'b0}};
            else if (tick_q) {f_future_q, f_mark_1_q, f_mark_2_q} <= {(f_future_q >> 1) | f_marks, f_future_q[0], f_mark_1_q};
            if (commit_q && i_longest != NONE) begin
                assume (f_next_rise == F_NEVER ? !f_next_early : f_next_rise < f_length);
                assume (f_next_rise == F_NEVER || (f_next_width != NONE && f_next_width <= i_longest));
                assume (f_next_rise == F_NEVER || f_next_word[TIMING_BITS-1:0] == f_next_fall[TIMING_BITS-1:0]);
                assume (!f_next_early || (f_next_wraps && f_next_fall != F_ZERO));
                assume (f_next_rise == F_NEVER || !f_next_wraps || f_length <= F_WRAPS);
            end
            if (f_reset_seen_q) begin
                assert (o_pins[f_k] == (f_mark_1_q || (f_mark_2_q && f_future_q[0])));
                assert (f_future_q == f_left);
                assert (!new_q[f_k] || (f_known_q && f_longest_q != NONE && !f_silent && f_new_left != F_ZERO && f_new_left <= f_width));
                assert (!old_q[f_k] || (f_known_q && f_old_left != {(WIDTH_BITS+1){1'b0}}));
                assert (!old_q[f_k] || (commit_q ? tick_q && f_old == NONE : f_old_left <= {1'b0, old_left_q} + {{WIDTH_BITS{1'b0}}, tick_q}));
                if (f_known_q && f_longest_q != NONE && !(commit_q && f_fresh_q)) begin
                    assert ({2'b00, rises_q[f_k*TIMING_BITS +: TIMING_BITS]} == f_rise_q);
                    assert (f_silent || falls_q[f_k*TIMING_BITS +: TIMING_BITS] == f_fall_q[TIMING_BITS-1:0]);
                    assert (f_silent ? !f_early_q : f_rise_q < f_length_q && f_width_q != NONE && f_width_q <= f_longest_q);
                    assert (f_silent || f_fall_q == (f_rise_q + f_width >= f_length_q ? f_rise_q + f_width - f_length_q : f_rise_q + f_width));
                    assert (f_silent || f_length_q <= F_WRAPS || f_rise_q + f_width < f_length_q);
                    assert (!f_early_q || (f_rise_q + f_width > f_length_q));
                end
                if (f_fresh_q && f_longest_q != NONE) assert (early[f_k] == f_early_q);
                if (f_age_q == F_CHANNELS - f_k) assert (f_next_word == f_word_q);
                // Without early, a pulse is high for its width; nothing is high for longer than the marks say.
                cover (f_starts && !off && f_future_q[1] && !f_future_q[2] && f_marks[2]);  // merges
                cover (f_starts && !off && f_future_q[2] && !f_marks[1]);  // within another
                cover (f_early && !off && f_future_q[F_TICKS-1:1] == {(F_TICKS-1){1'b0}} && f_marks[0]);  // early, and none under way
                cover (f_early && !off && f_future_q[1] && f_marks[1]);  // early, and one under way
                cover (o_pins[f_k] && !f_mark_1_q);  // a gap of one tick
                cover (!o_pins[f_k] && f_pin_past_q && !f_off_q);
                cover (commit_q && f_next_rise != F_NEVER && f_age_q == F_CHANNELS - f_k);
            end
        end
    end
endgenerate
`endif
