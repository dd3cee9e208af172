// SPDX-License-Identifier: Apache-2.0
// What width_pulse_generators promises, said another way than the module does it: a tick that starts a pulse marks the next ticks in
// which the channel must be high, as many as the pulse is wide. Overlapping pulses then merge by themselves, as an OR of marks. A pin
// is high in a marked tick, and in one between two marked ones. An early pulse is marked whole, by the word that waits, in the last
// cycle before that one's commit, and so is of one word; what is left of it is marked in each cycle's first tick, where it may be new.
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
        `F_EXPECT (!i_shift || (old_left_q == NONE && !commit_q && !i_words));
        `F_EXPECT (!i_words || old_left_q == NONE);
        `F_EXPECT (!i_cycle_start || i_tick);
        // When a pulse has started ahead, its word waits until it is committed at the cycle's end.
        `F_EXPECT (!ahead_q || old_q == {CHANNELS{1'b0}} || commit_q || (i_words && (!i_tick || i_near)));
    end
end
`undef F_EXPECT

`ifdef FORMAL_WIDTH_PULSE_GENERATORS
localparam F_TICKS = (1 << WIDTH_BITS) - 1;  // the widest pulse
localparam F_BITS  = TIMING_BITS + 2;        // of a tick's number
localparam [15:0] F_CHANNELS = CHANNELS[15:0];
localparam [F_BITS-1:0] F_NEVER = {2'b00, {TIMING_BITS{1'b1}}}, F_ZERO = 0;
localparam [F_BITS-1:0] F_ONE = 1, F_WRAPS = {2'b01, {TIMING_BITS{1'b0}}};  // the longest cycle over whose end a pulse may run
localparam [F_BITS-1:0] F_NEAR = 1 << (WIDTH_BITS - 1);  // so many ticks of a cycle's end are the last ones

// The cycle as cycle_controller drives it, of any length, also one longer than the channels can count. f_next_q is the number of the
// next tick, f_count_q that of the tick that the channels compare with. f_coming is the length of the cycle whose words wait.
(* anyseq *) wire [F_BITS-1:0] f_length, f_coming;
(* anyseq *) wire f_record_centred;
reg [F_BITS-1:0]     f_next_q, f_count_q, f_length_q, f_coming_q;
reg [WIDTH_BITS-1:0] f_longest_q;
reg                  f_fresh_q, f_known_q, f_off_q, f_waits_q, f_centred_q, f_centred_before_q;
initial f_known_q = 1'b0;
wire f_centred = commit_q ? f_centred_before_q : f_centred_q;  // the record whose words are played
wire f_last_tick = f_next_q + F_ONE == f_length;
wire [F_BITS-1:0] f_left   = f_length - F_ONE - f_next_q;      // ticks behind the next one
wire [F_BITS-1:0] f_behind = f_length_q - F_ONE - f_count_q;   // and behind the one that is compared
wire [F_BITS-1:0] f_number = f_coming - F_ONE - f_left;
always @(posedge clk) begin
    assert (f_reset_seen_q || !f_known_q);
    f_off_q   <= off;
    f_fresh_q <= commit_q && !rst;
    f_coming_q <= f_coming;
    // From a tick on in which pulses may start ahead, until the commit.
    f_waits_q <= !rst && !commit_q && (f_waits_q || (i_tick && ahead));
    f_centred_before_q <= f_centred_q;
    if (i_commit) f_centred_q <= f_record_centred;
    if (i_tick) begin
        {f_next_q, f_count_q} <= {f_last_tick ? F_ZERO : f_next_q + F_ONE, f_next_q};
        {f_length_q, f_longest_q} <= {f_length, i_longest};
        f_known_q <= f_reset_seen_q;
    end
    if (rst) {f_next_q, f_known_q} <= {F_ZERO, 1'b0};
    if (f_reset_seen_q && !rst) begin
        assume (commit_q || $past(rst) || f_length == $past(f_length));
        assume (f_length != F_ZERO && !f_length[F_BITS-1]);
        assume (f_coming != F_ZERO && !f_coming[F_BITS-1]);
        assume ({{(F_BITS-WIDTH_BITS){1'b0}}, i_longest} < f_length);
        assume (!i_commit || (i_tick ? f_last_tick : f_next_q == F_ZERO));
        assume (i_centred == f_centred_q);
        assume (!commit_q || !i_words);
        if (i_tick) begin
            assume (i_count == f_next_q[TIMING_BITS-1:0]);
            assume (i_can_match == (i_longest != NONE && f_next_q < F_NEVER));
            assume (!i_near || f_left < F_NEAR);
            assume (i_cycle_start == (f_next_q == F_ZERO));
            assume (!ahead || i_ahead_count == f_number[WIDTH_BITS-1:0]);
        end
        if (f_waits_q) begin
            assume (commit_q || (i_words && f_coming == f_coming_q));
            assume (!commit_q || f_length == f_coming_q);
            assume (!i_tick || commit_q || (i_near && f_next_q != F_ZERO));
        end
    end
    if (f_known_q) begin
        assert (f_count_q < f_length_q && !f_length_q[F_BITS-1] && count_q == f_count_q[TIMING_BITS-1:0]);
        assert (commit_q || f_fresh_q || f_length == f_length_q || rst);
        assert (f_next_q == (f_count_q + F_ONE == f_length_q ? F_ZERO : f_count_q + F_ONE));
        assert ({{(F_BITS-WIDTH_BITS){1'b0}}, f_longest_q} < f_length_q);
        assert (commit_q || (f_length_q == f_length && f_longest_q == i_longest) || rst);
        assert (start_q == (tick_q && f_longest_q != NONE && f_count_q < F_NEVER));
        assert (first_q == (tick_q && f_count_q == F_ZERO && f_longest_q != NONE));
        assert (!f_fresh_q || (tick_q && f_count_q == F_ZERO));
        assert (!commit_q || f_next_q == F_ZERO);
        assert (!f_waits_q || (ahead_q && f_behind < F_NEAR));
        assert (!commit_q || old_left_q == (f_centred ? (f_longest_q >> 1) + ONE : f_longest_q));
        assert (!ahead_q || f_waits_q);
    end else if (f_reset_seen_q) assert (!start_q && !first_q && !tick_q && !ahead_q && f_next_q == F_ZERO && (commit_q || i_longest == NONE));
    if (f_reset_seen_q) begin
        assert (!f_waits_q || (f_known_q && ahead_q));
        assert (!ahead_q || commit_q || old_left_q == NONE);
    end
end

// Follows any one word through the chain: f_word_q was shifted in f_age_q shifts ago; 0 means that no word is followed.
(* anyseq *) wire f_watch;
localparam WORD = 2 * TIMING_BITS + 1;
reg [WORD-1:0] f_word_q;
reg [15:0]     f_age_q;
always @(posedge clk) begin
    if (rst) f_age_q <= 16'd0;
    else if (i_shift && f_watch) {f_word_q, f_age_q} <= {i_word, 16'd1};
    else if (commit_q) f_age_q <= 16'd0;
    else if (i_shift && f_age_q != 16'd0) f_age_q <= f_age_q == F_CHANNELS ? 16'd0 : f_age_q + 1'b1;
    if (f_reset_seen_q) assert (f_age_q <= F_CHANNELS);
end

(* anyseq *) wire [CHANNELS*WIDTH_BITS-1:0] f_widths;  // of the pulses of the record that waits, or is being committed
reg [CHANNELS*WIDTH_BITS-1:0] f_widths_q;
always @(posedge clk) begin
    f_widths_q <= f_widths;
    if (f_waits_q) assume (f_widths == f_widths_q);
end
genvar f_k;
generate
    for (f_k = 0; f_k < CHANNELS; f_k = f_k + 1) begin : f_channel
        // The word that waits or is committed: as the header asks for it.
        wire [F_BITS-1:0]     f_next_length = commit_q ? f_length : f_coming;
        wire [WORD-1:0]       f_next_word  = {coming_q[f_k], next_falls_q[f_k*TIMING_BITS +: TIMING_BITS], next_rises_q[f_k*TIMING_BITS +: TIMING_BITS]};
        wire                  f_next_early = f_next_word[2*TIMING_BITS];
        wire [F_BITS-1:0]     f_next_rise  = {2'b00, f_next_word[TIMING_BITS-1:0]};
        wire [WIDTH_BITS-1:0] f_next_width = f_widths[f_k*WIDTH_BITS +: WIDTH_BITS];
        wire [F_BITS-1:0]     f_next_stop  = f_next_rise + {{(F_BITS-WIDTH_BITS){1'b0}}, f_next_width};
        wire                  f_next_wraps = f_next_stop >= f_next_length;
        wire [F_BITS-1:0]     f_next_fall  = f_next_wraps ? f_next_stop - f_next_length : f_next_stop;
        // The word that is played.
        reg [F_BITS-1:0]      f_rise_q, f_fall_q;
        reg [WIDTH_BITS-1:0]  f_width_q;
        reg                   f_early_q;
        wire                  f_silent = f_rise_q == F_NEVER;
        // Bit j: the channel is high in the j-th tick from now. Then the marks of the ticks before.
        reg [F_TICKS-1:0]     f_future_q;
        reg                   f_mark_1_q, f_mark_2_q, f_pin_past_q;
        // The word that waits says which early pulse starts.
        wire                  f_starts = tick_q && f_longest_q != NONE && !f_silent && f_count_q == f_rise_q && !f_early_q;
        wire                  f_ahead  = tick_q && f_waits_q && f_next_early && f_next_rise + f_behind + F_ONE == f_coming_q;
        wire                  f_early  = tick_q && f_count_q == F_ZERO && f_longest_q != NONE && f_early_q;
        wire [F_TICKS-1:0]    f_marks  = (f_starts ? ~({F_TICKS{1'b1}} << f_width_q) : {F_TICKS{1'b0}})
                                       | (f_ahead ? ~({F_TICKS{1'b1}} << f_next_width) : {F_TICKS{1'b0}})
                                       | (f_early ? ~({F_TICKS{1'b1}} << f_fall_q) : {F_TICKS{1'b0}});
        // The same, computed from fall: how long new_q and old_q stay high.
        wire [F_BITS-1:0]     f_to_fall  = f_fall_q >= f_count_q ? f_fall_q - f_count_q : f_fall_q + f_length_q - f_count_q;
        wire [F_BITS-1:0]     f_new_left = f_to_fall + {{(F_BITS-1){1'b0}}, tick_q};
        wire [WIDTH_BITS-1:0] f_old      = next_rises_q[f_k*TIMING_BITS +: WIDTH_BITS] - old_count_q;
        wire [WIDTH_BITS:0]   f_old_left = {1'b0, f_old} + {{WIDTH_BITS{1'b0}}, tick_q};
        wire [F_BITS-1:0]     f_ahead_left = f_behind + f_next_fall + {{(F_BITS-1){1'b0}}, tick_q} + F_ONE;
        wire [F_TICKS-1:0]    f_left_old = f_waits_q ? ~({F_TICKS{1'b1}} << f_ahead_left) : ~({F_TICKS{1'b1}} << f_old_left);
        wire [F_TICKS-1:0]    f_left_all = (new_q[f_k] ? ~({F_TICKS{1'b1}} << f_new_left) : {F_TICKS{1'b0}})
                                         | (old_q[f_k] ? f_left_old : {F_TICKS{1'b0}});
        wire [F_BITS-1:0]     f_width    = {{(F_BITS-WIDTH_BITS){1'b0}}, f_width_q};
        always @(posedge clk) begin
            f_pin_past_q <= o_pins[f_k];
            if (commit_q) {f_rise_q, f_fall_q, f_width_q, f_early_q} <= {f_next_rise, f_next_fall, f_next_width, f_next_early};
            if (off) {f_future_q, f_mark_1_q, f_mark_2_q} <= {(F_TICKS+2){1'b0}};
            else if (tick_q) {f_future_q, f_mark_1_q, f_mark_2_q} <= {(f_future_q >> 1) | f_marks, f_future_q[0], f_mark_1_q};
            if ((commit_q && i_longest != NONE) || f_waits_q) begin
                assume (f_next_rise == F_NEVER ? !f_next_early : f_next_rise < f_next_length);
                assume (f_next_rise == F_NEVER || (f_next_width != NONE && {2'b00, {(TIMING_BITS-WIDTH_BITS){1'b0}}, f_next_width} < f_next_length));
                assume (f_next_rise == F_NEVER || f_next_word[2*TIMING_BITS-1:TIMING_BITS] == f_next_fall[TIMING_BITS-1:0]);
                assume (!f_next_early || (f_next_wraps && f_next_fall != F_ZERO && f_next_rise + F_NEAR >= f_next_length));
                assume (f_next_rise == F_NEVER || !f_next_wraps || f_next_length <= F_WRAPS);
            end
            if (commit_q && i_longest != NONE) begin
                assume (f_next_rise == F_NEVER || f_next_width <= i_longest);
                assume (!f_centred_q || f_next_rise == F_NEVER || f_next_early || !f_next_wraps || f_next_fall <= {2'b00, {(TIMING_BITS-WIDTH_BITS){1'b0}}, i_longest >> 1});
            end
            if (commit_q && f_waits_q && i_longest == NONE) assume (f_next_rise == F_NEVER);
            if (f_reset_seen_q) begin
                assert (o_pins[f_k] == (f_mark_1_q || (f_mark_2_q && f_future_q[0])));
                assert (f_future_q == f_left_all);
                assert (!new_q[f_k] || (f_known_q && f_longest_q != NONE && !f_silent && f_new_left != F_ZERO && f_new_left <= f_width));
                assert (!old_q[f_k] || f_known_q);
                if (f_waits_q) begin
                    assert (!old_q[f_k] || (f_next_early && f_next_rise + f_behind + F_ONE + {{(F_BITS-1){1'b0}}, tick_q} <= f_coming_q));
                end else begin
                    assert (!old_q[f_k] || f_old_left != {(WIDTH_BITS+1){1'b0}});
                    assert (!old_q[f_k] || (commit_q ? tick_q && f_old == NONE : f_old_left <= {1'b0, old_left_q} + {{WIDTH_BITS{1'b0}}, tick_q}));
                end
                if (f_known_q && f_longest_q != NONE && !(commit_q && f_fresh_q)) begin
                    assert ({2'b00, rises_q[f_k*TIMING_BITS +: TIMING_BITS]} == f_rise_q && early_q[f_k] == f_early_q);
                    assert (f_silent || falls_q[f_k*TIMING_BITS +: TIMING_BITS] == f_fall_q[TIMING_BITS-1:0]);
                    assert (f_silent ? !f_early_q : f_rise_q < f_length_q && f_width_q != NONE && f_width_q <= f_longest_q);
                    assert (f_silent || f_fall_q == (f_rise_q + f_width >= f_length_q ? f_rise_q + f_width - f_length_q : f_rise_q + f_width));
                    assert (f_silent || f_length_q <= F_WRAPS || f_rise_q + f_width < f_length_q);
                    assert (!f_early_q || (f_rise_q + f_width > f_length_q && f_rise_q + F_NEAR >= f_length_q));
                    // Beyond its cycle a centred pulse lasts for half of the longest, and an early one ends in it.
                    assert (!f_centred || f_silent || f_early_q || f_rise_q + f_width < f_length_q || f_fall_q <= {2'b00, {(TIMING_BITS-WIDTH_BITS){1'b0}}, f_longest_q >> 1});
                    assert (!new_q[f_k] || !f_early_q || f_to_fall <= f_fall_q);
                end
                if (f_age_q == F_CHANNELS - f_k) assert (f_next_word == f_word_q);
                // Without early, a pulse is high for its width; nothing is high for longer than the marks say.
                cover (f_starts && !off && f_future_q[1] && !f_future_q[2] && f_marks[2]);  // merges
                cover (f_starts && !off && f_future_q[2] && !f_marks[1]);  // within another
                cover (f_ahead && !off && f_early_q && f_centred && f_next_width != f_width_q);  // of one word, then of another
                cover (f_ahead && !off && f_coming_q != f_length_q);
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
