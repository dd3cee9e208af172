// SPDX-License-Identifier: Apache-2.0
// A frame of DISABLE or STOP and nothing else acts at its end if its CRC is right, and no other frame does. What then counts as old is old_frames.vh's.
reg [7:0] f_second_q, f_bytes_q;  // of the frame that arrives
reg [BITS-1:0] f_waiting_q;
reg       f_begun_q, f_reset_seen_q;
initial f_reset_seen_q = 1'b0;
wire f_acts    = i_right && f_bytes_q == 8'd4;
wire f_disable = f_acts && f_second_q == `HG_COMMAND_DISABLE;
wire f_stop    = i_stops || (f_acts && f_second_q == `HG_COMMAND_STOP);
always @(posedge clk) begin
    f_reset_seen_q <= f_reset_seen_q || rst;
    if (i_valid && f_bytes_q == 8'd1) f_second_q <= i_byte;
    if (rst) {f_bytes_q, f_begun_q, f_waiting_q} <= {(BITS+9){1'b0}};
    else begin
        if (i_end) f_bytes_q <= 8'd0;
        else if (i_valid && f_bytes_q != 8'hff) f_bytes_q <= f_bytes_q + 1'b1;
        f_begun_q   <= !i_end && (f_begun_q || i_arrives);
        f_waiting_q <= f_waiting_q + {{(BITS-1){1'b0}}, i_good} - {{(BITS-1){1'b0}}, i_done};
    end
`ifdef FORMAL_URGENT_COMMANDS
    assume (!i_right || i_end);
    assume (!i_good || (i_right && f_begun_q));
    assume (!i_end || !i_valid);
    assume (!i_valid || i_arrives);
    assume (!i_done || f_waiting_q != {BITS{1'b0}});
    assume (!i_good || f_waiting_q < FRAMES[BITS-1:0]);
    assume (f_reset_seen_q || rst);
`endif
    if (f_reset_seen_q) begin
        if (!$past(rst) && $past(i_off || f_disable || i_old[0])) assert (o_disable);
        if (!$past(rst) && $past(f_stop || i_old[1])) assert (o_stop);
        if (!$past(rst) && $past(f_stop)) assert (o_stops);
        if (!$past(rst) && $past(i_ends || i_old[2])) assert (o_ended);
        if (!$past(rst) && $past(o_stop) && !o_stop && $past(o_stop, 2)) assert (o_stops || !$past(o_stop, 2) || $past(f_stop, 2));
        if (!$past(rst)) assert (o_heard == $past(f_disable || f_stop));
        // Without any of it, nothing is old.
        if (!$past(rst) && $past(!o_disable && !i_off && !f_disable && !i_old[0] && !i_good)) assert (!o_disable);
        if (!$past(rst) && $past(!o_stop && !f_stop && !i_old[1] && !i_good)) assert (!o_stop);
        if (!$past(rst) && $past(!o_ended && !i_ends && !i_old[2] && !i_good)) assert (!o_ended);
        assert (waiting_q == f_waiting_q && f_waiting_q <= FRAMES[BITS-1:0]);
`ifdef FORMAL_URGENT_COMMANDS
        assert (begun_q == f_begun_q && (f_begun_q || f_bytes_q == 8'd0));
        assert (count_q == (f_bytes_q > 8'd5 ? 3'd5 : f_bytes_q[2:0]));
        assert (f_bytes_q < 8'd2 || {disables_q, stops_q} == {f_second_q == `HG_COMMAND_DISABLE, f_second_q == `HG_COMMAND_STOP});
        cover (o_disable && o_stop && waiting_q == FRAMES[BITS-1:0]);
        cover ($past(o_disable) && !o_disable && f_waiting_q != {BITS{1'b0}});
        cover (o_heard && !$past(i_good));
        cover (o_ended && !o_disable && !o_stop);
`endif
    end
end
