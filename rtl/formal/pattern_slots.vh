// SPDX-License-Identifier: Apache-2.0
// A stream's contract: a period plays nothing but its own pattern, and that whole.
reg f_plays_q;  // the slot whose turn it was is being read
initial f_plays_q = 1'b0;
always @(posedge clk) begin
    f_plays_q <= !i_go && (f_plays_q || (o_turn && o_full));
    if (fills) assert (!waits[slot]);
    if (i_take && keeps_q && f_plays_q) assert (slot != turn_slot);
end
`ifdef FORMAL_PATTERN_SLOTS
(* anyconst *) wire [PERIOD_BITS-1:0] f_period;  // any one
reg       f_whole_q;                  // its pattern has been taken whole, and is to be played
reg       f_frame_q, f_paused_q;
reg [1:0] f_since_go_q;
initial {f_whole_q, f_frame_q, f_paused_q, f_since_go_q} = 5'd3;
wire [BITS-1:0] f_slot = f_period[BITS-1:0] & mask[BITS-1:0];
wire f_turn = o_turn && decided_q == f_period;
always @(posedge clk) begin
    // Settings stay. A frame's words come one a clock, but for one in which its word is being read; go points are far from each other.
    assume (i_slot_bits == 4'd1 || i_slot_bits == 4'd2);
    assume ($past(i_slot_bits) == i_slot_bits && i_first == 16'd1);
    assume (!i_settle || !f_frame_q);
    assume (!i_take || (f_frame_q && !o_wait));
    assume (i_take || o_wait || !f_frame_q || !f_paused_q || i_close);
    assume (!i_close || (f_frame_q && !i_take));
    assume (!i_go || &f_since_go_q);
    assume (!o_jump || i_forget);
    f_frame_q    <= i_settle || (f_frame_q && !i_close);
    f_paused_q   <= !i_take && !o_wait;
    f_since_go_q <= i_go ? 2'd0 : &f_since_go_q ? f_since_go_q : f_since_go_q + 2'd1;
    f_whole_q    <= !i_forget && !f_turn && (f_whole_q || (fills && period_q == f_period));
    if (f_turn && o_full) assert (f_whole_q);
    if (f_turn && f_whole_q) assert (o_full);
    if (f_whole_q && i_take && keeps_q) assert (slot != f_slot);
    cover (f_turn && o_full);
    cover (o_turn && !o_full);
    cover (o_late && ends);
    cover (o_early);
    cover (o_repeated);
end
`endif
