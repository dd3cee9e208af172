// SPDX-License-Identifier: Apache-2.0
// What period_controller promises beside the pulses themselves. It is checked in simulation, on what drive_player drives it with.
reg        f_reset_seen_q, f_short_q;
reg [3:0]  f_clocks_q;   // since the cycle began, as far as 8
reg [3:0]  f_near_q;     // of those, at the go point or behind it
reg signed [1:0] f_ahead_q;  // o_period strobes that there were more than cycles
initial f_reset_seen_q = 1'b0;
wire signed [1:0] f_given = {1'b0, given_q}, f_owed = {1'b0, owed_q};
always @(posedge clk) begin
    f_reset_seen_q <= f_reset_seen_q || rst;
    if (rst) {f_near_q, f_ahead_q, f_clocks_q, f_short_q} <= 11'b0010000;
    else begin
        f_ahead_q  <= f_ahead_q + {1'b0, o_period} - {1'b0, i_cycle_start};
        f_clocks_q <= i_cycle_start ? 4'd1 : f_clocks_q == 4'd8 ? 4'd8 : f_clocks_q + 4'd1;
        f_near_q   <= i_cycle_start ? 4'd0 : left_q == 24'd0 && f_near_q != 4'd10 ? f_near_q + 4'd1 : f_near_q;
        if (i_cycle_start && f_clocks_q < 4'd8) f_short_q <= 1'b1;  // contract 9 does not count cycles as short as that
    end
    if (f_reset_seen_q && !rst) begin
`ifdef FORMAL_PERIOD_CONTROLLER
        // Whatever else it is driven with, for cycles of eight clocks or more.
        assume (!i_cycle_start || f_clocks_q == 4'd8);
        cover (f_near_q == 4'd4 && !given_q);
        cover (owed_q && o_period);
`else
        assert (!(o_ready && o_refresh) && (!prepared_q || busy_q) && (!taken_q || busy_q));
        // One strobe a cycle, and four clocks from each to the next.
        assert (f_short_q || f_ahead_q == f_given - f_owed);
        assert (!o_period || given_before_q == 3'd0);
`endif
        // So from every state a cycle that is longer than ten clocks behind its go point has come to it.
        assert (f_short_q || f_near_q < 4'd9 || given_q);
`ifndef FORMAL_PERIOD_CONTROLLER
        // A record is taken over whole, when nothing is under way; and words come only while some are being made.
        assert (!o_take_over || (i_next && !busy_q && i_settled && !i_preempt));
        assert (!i_word || (busy_q && !prepared_q));
        assert (!o_begin || !(sweeps_q || valid_1_q || valid_2_q || i_word));
        cover (o_drop);
        cover (o_take_over && forced);
        cover (i_commit && again_q);
        cover (o_missed);
`endif
    end
end
