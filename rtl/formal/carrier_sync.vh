// SPDX-License-Identifier: Apache-2.0
// The last clock of a cycle is repeated a bounded number of times, and nothing else happens to a cycle; together with the proof of
// cycle_controller, by which it repeats no other clock, no tick is skipped and no cycle is shortened, whatever comes over the wire.
reg        f_past_q;    // there was a clock before this one, and in simulation a reset
reg [3:0]  f_held_q;    // times that this cycle's last clock was repeated
reg        f_turn_q;    // cycles, modulo 2
reg [6:0]  f_missed_q;  // cycles in a row without an edge in time, of a slave in step
initial f_past_q = 1'b0;
wire f_late_edge = slave && o_in_step && o_ends && (since_q < DUE || since_q > DUE + 7'd1 || f_held_q > 4'd2);
always @(posedge clk) begin
`ifdef FORMAL_CARRIER_SYNC
    f_past_q <= 1'b1;
`else
    f_past_q <= f_past_q || rst;
`endif
    f_held_q <= i_last && o_hold && !rst ? f_held_q + 1'b1 : 4'd0;
    f_turn_q <= !rst && f_turn_q ^ (i_last && !o_hold);
    if (rst || (slave && o_ends && !f_late_edge) || !o_in_step) f_missed_q <= 7'd0;
    else if (f_late_edge) f_missed_q <= f_missed_q + 1'b1;
`ifdef FORMAL_CARRIER_SYNC
    assume (i_role != 2'd3);
    // Any state that the assertions allow may be the first one: a slave that is in step, for example.
    if (!f_past_q) assume (waited_q == f_held_q && f_held_q <= MOST && turn_q == f_turn_q && i_role != 2'd3
                           && f_missed_q == {3'b000, misses_q} && (!o_in_step || slave));
    if (!f_past_q && f_held_q != 4'd0) assume (slave || (master && longer));
    if (!f_past_q) assume (!(slave && o_in_step && unheard && f_held_q > 4'd1) && !(master && f_held_q > 4'd1));
    if (!f_past_q) assume (i_last || f_held_q == 4'd0);
    if (f_past_q && $past(i_last && o_hold) && !$past(rst)) assume (i_last);  // cycle_controller repeats it
    if (f_past_q && !rst) assume (i_role == $past(i_role));
`endif
    // The edge that a slave has heard is none that it drives when it becomes the master.
    if (f_past_q && $past(rst)) assert (!o_sync);
    if (f_past_q && !rst) begin
        assert (waited_q == f_held_q && f_held_q <= MOST);
        assert (o_ends == (i_last && !o_hold));
        assert (i_role != `HG_ROLE_ALONE || !o_hold);
        assert (!master || turn_q == f_turn_q);
        assert (!master || !o_ends || f_held_q == {3'd0, !f_turn_q});
        assert (!(slave && o_in_step && o_ends && unheard) || f_held_q <= 4'd1);
        assert (!o_in_step || slave);
        // 16 cycles without an edge in time, and it is out of step.
        assert (f_missed_q <= 7'd16 && (!o_in_step || f_missed_q == {3'b000, misses_q}));
        assert (!(f_late_edge && f_missed_q == 7'd15) || o_lost);
        if ($past(o_lost)) assert (!o_in_step);
        if ($past(o_in_step) && !o_in_step) assert ($past(rst || o_lost));
        cover (slave && o_ends && !o_in_step && f_held_q == MOST);
        cover (slave && o_ends && o_in_step && f_held_q == 4'd1 && unheard);
        cover (slave && o_ends && o_in_step && f_held_q == 4'd4);
        cover (master && o_ends && f_held_q == 4'd1);
        cover ($past(o_lost));
        cover (!$past(o_in_step) && o_in_step);
    end
end
