// SPDX-License-Identifier: Apache-2.0
// Contract 13: a period plays nothing but its own pattern, and that whole.
reg f_plays_q;  // the slot whose turn it was is being read
initial f_plays_q = 1'b0;
always @(posedge clk) begin
    f_plays_q <= !i_go && (f_plays_q || (o_turn && o_full));
    if (fills) assert (!waits[slot]);
    if (i_take && keeps_q && f_plays_q) assert (slot != turn_slot);
end
