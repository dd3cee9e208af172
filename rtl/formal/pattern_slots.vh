// SPDX-License-Identifier: Apache-2.0
// Contract 13: a period plays nothing but its own pattern, and that whole.
reg f_plays_q;  // the slot whose turn it was is being read
initial f_plays_q = 1'b0;
always @(posedge clk) begin
    f_plays_q <= !i_go && (f_plays_q || (o_turn && o_full));
    if (fills) assert (!waits[slot]);
    if (i_take && keeps_q && f_plays_q) assert (slot != turn_slot);
end

`ifdef FORMAL_PATTERN_SLOTS
// Any one slot is followed, and which period its pattern is for.
(* anyconst *) wire [BITS-1:0] f_slot;
reg [PERIOD_BITS-1:0] f_period_q;
reg       f_open_q, f_past_q;  // within a frame
reg [2:0] f_since_q;           // clocks since the last i_go, at most 7
reg [2:0] f_gos_q;             // periods since the present pattern was judged
reg       f_meets_q;           // the bit that is here was read while it was written
initial {f_open_q, f_past_q, f_since_q, f_gos_q, f_meets_q} = 0;
wire f_writes = f_open_q && !o_wait && keeps_q;
wire [PERIOD_BITS-1:0] f_ahead  = f_period_q - decided_q;  // of the followed slot's pattern
wire [PERIOD_BITS-1:0] f_judged = ahead + {{(PERIOD_BITS-3){1'b0}}, f_gos_q};
integer f_s;

// What its neighbours do: command_unit gives words within a frame, one that is not the last of a pattern for a time, and
// pattern_stream forgets when periods do not follow each other, and when it changes the settings.
always @(posedge clk) begin
    f_past_q  <= 1'b1;
    f_open_q  <= i_settle || (f_open_q && !i_close);
    f_since_q <= i_go ? 3'd0 : f_since_q == 3'd7 ? f_since_q : f_since_q + 3'd1;
    f_gos_q   <= judges ? {2'd0, i_go} : f_gos_q + {2'd0, i_go};
    f_meets_q <= (turn_q[0] ? turn_slot : slot) == (sweeps ? sweep_q[BITS-1:0] : fills ? slot : turn_slot) && (sweeps || fills || clears_q);
    if (fills && slot == f_slot) f_period_q <= period_q;
    assume (!i_take || (f_open_q && !o_wait));
    assume (!i_settle || !i_take);
    assume (!i_close || (!i_take && !i_settle));
    assume (!i_go || f_since_q == 3'd7);
    assume (!i_go || f_gos_q != 3'd7);
    assume (!o_jump || i_forget);
    assume (i_slot_bits != 4'd0 && i_slot_bits <= MOST_BITS);
    if (f_past_q) assume (i_slot_bits == $past(i_slot_bits) || $past(i_forget));
end

always @(posedge clk) begin
    // What plays is the pattern of that period.
    if (o_turn && o_full && turn_slot == f_slot) assert (f_period_q == decided_q);
    // A memory need not say what is read while it is written.
    if (f_meets_q) assert (!(o_turn && swept_q) && !(judges && !i_forget && !late && !early));
    // What waits is for one of the periods that are still to come, each in its own slot, or is just having its turn.
    if (waits[f_slot] && !sweeps) begin
        assert ((f_ahead & ~mask) == NONE);
        assert ((f_period_q[BITS-1:0] & mask[BITS-1:0]) == f_slot);
        assert (f_ahead != NONE || turn_q[0] || clears_q);
    end
    // A pattern that is being written was for such a period when it was judged, and its slot was and stays empty.
    if (f_writes) begin
        assert (!sweeps && swept_q);
        assert (!waits[slot]);
        assert ((f_judged & ~mask) == NONE && f_judged != NONE);
        if (f_plays_q) assert (slot != turn_slot);
    end
    if (steps_q[4] && swept_q && waits[slot]) assert (full_q);
    if (o_wait) assert (steps_q == 4'b0001 || steps_q == 4'b0010 || steps_q == 4'b0100 || steps_q == 4'b1000);
    if (swept_q) assert (!sweeps);
    // From where the sweep is on, a slot may still be full.
    for (f_s = 0; f_s < SLOTS; f_s = f_s + 1)
        if (sweeps && f_s < sweep_q) assert (!waits[f_s]);
    if (sweep_q[BITS]) assert (sweep_q[BITS-1:0] == 0);
    if (turn_q[0]) assert (f_since_q == 3'd0);
    if (turn_q[1]) assert (f_since_q == 3'd1);
    if (clears_q) assert (f_since_q <= 3'd3);
    cover (o_turn && o_full && turn_slot == f_slot && i_slot_bits == MOST_BITS);
    cover (ends && keeps_q && late);
    cover (o_repeated);
    cover (o_early);
end
`endif
