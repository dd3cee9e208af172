// SPDX-License-Identifier: Apache-2.0
reg        f_reset_seen_q;
reg [7:0]  f_left_q;    // clocks left in this cycle, modulo 256
reg [15:0] f_dwell_q;   // as it was offered
reg [15:0] f_played_q;  // whole cycles since the last commit
reg        f_asked_q;
initial f_reset_seen_q = 1'b0;
wire [23:0] cycle_length_q = last_count_q + 1'b1;
wire [23:0] prescaler_q = last_phase_q + 1'b1;
wire [7:0] f_ticks  = cycle_length_q[7:0] - count_q[7:0];
wire       f_due    = f_dwell_q != 16'd0 && f_played_q >= f_dwell_q - 1'b1;
wire       f_change = f_due || f_asked_q || f_dwell_q == 16'd0;
wire       f_at_once = !i_allow && f_asked_q && i_ready && i_settled;  // nothing to complete, so no reason to wait
reg        f_held_q;    // the last clock was repeated
wire       f_holds = cycle_length_q - count_q == 24'd1 && prescaler_q - phase_q == 24'd1 && i_hold && !f_at_once;
always @(posedge clk) begin
    f_reset_seen_q <= f_reset_seen_q || rst;
    f_held_q       <= f_holds && !rst;
    if (!f_holds) f_left_q <= f_left_q - 1'b1;
    if (boundary) f_left_q <= o_commit && !i_silent ? i_cycle_length[7:0] * i_prescaler[7:0] : cycle_length_q[7:0] * prescaler_q[7:0];
    if (boundary && f_played_q != 16'hffff) f_played_q <= f_played_q + 1'b1;
    if (o_commit) {f_dwell_q, f_played_q} <= {i_dwell, 16'd0};
    if (i_preempt || o_commit) f_asked_q <= i_preempt;
    if (rst) {f_left_q, f_dwell_q, f_played_q, f_asked_q} <= {IDLE_CYCLE[7:0], 33'd0};
`ifdef FORMAL_CYCLE_CONTROLLER
    assume (!(i_ready && i_refresh));
    if (i_ready && !i_silent) assume (i_cycle_length >= 1 && i_cycle_length < 8 && i_prescaler >= 1 && i_prescaler < 4);
    if (f_reset_seen_q) assert (cycle_length_q < 8 && prescaler_q < 4 && boundary == ((f_left_q == 8'd1 && !i_hold) || f_at_once));
`else
    if (f_reset_seen_q) assert (!(i_ready && i_refresh));
    if (f_reset_seen_q && i_ready && !i_silent) assert (i_cycle_length != 0 && i_prescaler != 0);
`endif
    if (f_reset_seen_q) begin
        assert (o_tick == (phase_q == 24'd0 && !f_held_q) && o_cycle_start == (o_tick && count_q == 24'd0));
        assert (count_q < cycle_length_q && phase_q < prescaler_q && f_left_q == f_ticks * prescaler_q[7:0] - phase_q[7:0]);
        assert (preempt_q == f_asked_q && dwell_q == (f_dwell_q == 0 ? 16'd0 : f_due ? 16'd1 : f_dwell_q - f_played_q));
        assert (f_asked_q || late_q == (f_dwell_q != 0 && f_played_q >= f_dwell_q));
        assert (quarter_q == cycle_length_q >> 2);
        assert (o_near == (prescaler_q == 24'd1 && {16'd0, f_left_q} <= quarter_q && {24'd0, f_left_q} <= 1 << (PULSE_BITS - 1)) || cycle_length_q > 24'd255);
        cover (o_near && f_left_q == 8'd1 && !o_commit);
        // A cycle starts right after the last one, and ends where its length says.
        assert (o_cycle_start == ($past(boundary) || $past(rst)));
        assert (!boundary || (f_left_q == 8'd1 && !i_hold) || f_at_once);
        // A held cycle stands still at its last clock: no tick, no change.
        if (f_held_q) assert ($past({count_q, phase_q}) == {count_q, phase_q} && !o_tick && o_last);
        assert (o_commit == (boundary && i_ready && i_settled && f_change));
        assert (o_underrun == (boundary && !(i_ready && i_settled) && !f_asked_q && f_due && f_played_q == f_dwell_q - 1'b1));
        if ($past(o_commit) && !$past(rst)) begin
            assert (o_index == $past(i_index) && o_pulse_length == ($past(i_silent) ? 0 : $past(i_pulse_length)));
            assert ({cycle_length_q, prescaler_q} == ($past(i_silent) ? $past({cycle_length_q, prescaler_q})
                                                                      : $past({i_cycle_length, i_prescaler})));
        end else if (!$past(rst)) begin
            assert ($past({o_index, cycle_length_q, prescaler_q}) == {o_index, cycle_length_q, prescaler_q});
            assert (o_pulse_length == ($past(o_refresh) ? $past(i_pulse_length) : $past(o_pulse_length)));
        end
        assert (o_refresh == (boundary && i_refresh && i_settled) && o_follows == f_change && o_asked == f_asked_q);
        cover (o_refresh && f_dwell_q == 16'd2);
        cover (o_commit && f_dwell_q == 16'd2 && !f_asked_q && prescaler_q == 24'd2 && cycle_length_q == 24'd3);
        cover (o_commit && f_asked_q && !f_due && f_dwell_q != 16'd0);
        cover (o_commit && late_q);
        cover (o_commit && f_left_q > 8'd2);
        cover (o_commit && f_held_q && prescaler_q == 24'd2);
    end
end
