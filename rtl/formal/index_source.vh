// SPDX-License-Identifier: Apache-2.0
// Contract 10: entries come out of one bank and then out of the other; the last of the one is followed by the first of the other.
reg f_reset_seen_q;
initial f_reset_seen_q = 1'b0;
`ifdef FORMAL_INDEX_SOURCE
always @(posedge clk) if (f_reset_seen_q && !rst) begin
    // command_check's verdict: banks lie within sequence memory.
    if (i_start || i_follow) assume (i_argument_1 == 16'd0
        || (i_argument_0 >= 16'd1 && i_argument_0 < SEQUENCE_DEPTH && i_argument_1 < SEQUENCE_DEPTH && i_argument_0 + i_argument_1 <= SEQUENCE_DEPTH));
    assume (!i_live_valid || !i_live_empty);
    assume ({1'b0, i_select} + {1'b0, i_start} + {1'b0, i_stop} <= 2'd1);
end
`endif
reg [31:0] f_taken_q;     // the last entry that was taken, but for one that a preempt drops
reg [2:0]  f_follows_q;   // clocks since a follower has begun, one-hot; none when something else was asked for since
reg        f_plays_q;     // it was taken from a selected index or a sequence, and no command has come since
wire       f_asked = commanded || enter_live || rst;
always @(posedge clk) begin
    f_reset_seen_q <= f_reset_seen_q || rst;
    f_follows_q <= {f_follows_q[1:0], follows && i_argument_1 != 16'd0} & {3{!f_asked}};
    f_plays_q <= !f_asked && (f_plays_q || (taken && mode_q != IDLE));
    if (rst) f_taken_q <= 32'd0;
    else if (o_entry && i_take) f_taken_q <= {o_dwell, o_index};
    if (f_reset_seen_q) begin
        // The entry that is fetched is one of the bank.
        if (mode_q == SEQUENCE && !header_q) assert (first_q <= number_q && number_q <= last_q && first_q != {BITS{1'b0}});
        if (fetch_q[0] && !header_q) assert (mode_q == SEQUENCE && o_sequence_address == number_q);
        if (follows && mode_q == SEQUENCE) assert (number_q == last_q && offer_q && i_take && loops_q <= 16'd1);
        if (follows && mode_q == LIVE) assert (i_live_empty);
        assert (fetch_q == 3'b000 || fetch_q == 3'b001 || fetch_q == 3'b010 || fetch_q == 3'b100);
        if (fetch_q != 3'd0) assert (!offer_q);
        if (mode_q == IDLE) assert (offer_q ? entry_q == 32'd0 : f_taken_q == 32'd0);
        if (after_reset_q) assert (fetch_q != 3'd0);
        // What is not read to its end does not start by itself.
        if (i_fills) assert (!o_autostart);
        if (fetch_q != 3'd0) assert (mode_q == SEQUENCE ? !after_reset_q : mode_q == IDLE && header_q && after_reset_q);
        if (mode_q != IDLE || after_reset_q) assert (ended_q == IDLE);
        if (!$past(rst)) begin
            // Whoever hears nothing and is told IDLE knows that nothing is to come: an entry that was taken may still be waiting to
            // play until the next one, silence, is taken.
            if (offer_q && f_taken_q != 32'd0 && f_plays_q) assert (o_mode != IDLE);
            // A follower asks for no change before the end, and drops nothing but silence.
            assert (o_preempt == $past(commanded || enter_live));
            if ($past(follows)) assert (!o_preempt && mode_q == SEQUENCE && fetch_q == 3'b001);
            if (o_drop) assert (f_taken_q == 32'd0);
            // Its first entry is fetched in the next clock, and can be taken three clocks later.
            if (f_follows_q[0]) assert (fetch_q[0] && {{(16-BITS){1'b0}}, o_sequence_address} == $past(i_argument_0));
        end
        cover (follows && mode_q == SEQUENCE && loops_q == 16'd0 && first_q != last_q);
        cover (o_drop);
        cover (o_autostart);
        cover (mode_q == IDLE && ended_q == SEQUENCE);
        cover (follows && mode_q == LIVE);
        cover (f_follows_q[2]);
    end
end
