// SPDX-License-Identifier: Apache-2.0
// The same said with a list: a bit for each frame that waits, oldest first, which says whether it is an urgent one of that kind.
reg [FRAMES-1:0] f_disables_q, f_stops_q;
reg [BITS-1:0]   f_waiting_q;
reg [7:0]        f_second_q, f_bytes_q;  // of the frame that arrives
reg              f_applied_q;                       // its number lay behind when it arrived
reg              f_reset_seen_q;
initial f_reset_seen_q = 1'b0;
wire f_short   = f_bytes_q == 8'd4 && !f_applied_q;
wire f_disable = f_short && f_second_q == `HG_COMMAND_DISABLE;
wire f_stop    = f_short && f_second_q == `HG_COMMAND_STOP;
wire [BITS-1:0]   f_kept = f_waiting_q - {{(BITS-1){1'b0}}, i_done};
wire [FRAMES-1:0] f_place = {{(FRAMES-1){1'b0}}, i_good} << f_kept;
always @(posedge clk) begin
    f_reset_seen_q <= f_reset_seen_q || rst;
    if (i_valid && f_bytes_q == 8'd0) f_applied_q <= i_session && (i_expected - i_byte - 8'd1) < 8'd128;
    if (i_valid && f_bytes_q == 8'd1) f_second_q <= i_byte;
    if (rst) {f_disables_q, f_stops_q, f_waiting_q, f_bytes_q} <= {(2*FRAMES+BITS+8){1'b0}};
    else begin
        if (i_end) f_bytes_q <= 8'd0;
        else if (i_valid && f_bytes_q != 8'hff) f_bytes_q <= f_bytes_q + 1'b1;
        f_waiting_q  <= f_kept + {{(BITS-1){1'b0}}, i_good};
        f_disables_q <= (f_disables_q >> i_done) | (f_disable ? f_place : {FRAMES{1'b0}});
        f_stops_q    <= (f_stops_q >> i_done) | (f_stop ? f_place : {FRAMES{1'b0}});
    end
`ifdef FORMAL_URGENT_COMMANDS
    assume (!i_good || i_end);
    assume (!i_end || !i_valid);
    assume (!i_done || f_waiting_q != NONE);
    assume (!i_good || f_waiting_q < FRAMES[BITS-1:0]);
    assume (f_reset_seen_q || rst);
`endif
    if (f_reset_seen_q) begin
        assert (f_waiting_q <= FRAMES[BITS-1:0] && waiting_q == f_waiting_q);
        assert (o_disable == (f_disables_q != {FRAMES{1'b0}}));
        assert (o_stop == (f_stops_q != {FRAMES{1'b0}}));
`ifdef FORMAL_URGENT_COMMANDS
        assert (f_disables_q >> disable_left_q == 0 && f_stops_q >> stop_left_q == 0);
        assert (disable_left_q <= waiting_q && stop_left_q <= waiting_q);
        assert ((disable_left_q != NONE) == o_disable && (stop_left_q != NONE) == o_stop);
        assert (!o_disable || f_disables_q[disable_left_q - ONE]);
        assert (!o_stop || f_stops_q[stop_left_q - ONE]);
        assert (count_q == (f_bytes_q > 8'd5 ? 3'd5 : f_bytes_q[2:0]));
        assert (f_bytes_q == 8'd0 || new_q == !f_applied_q);
        assert (f_bytes_q < 8'd2 || {disables_q, stops_q} == {f_second_q == `HG_COMMAND_DISABLE, f_second_q == `HG_COMMAND_STOP});
        cover (o_disable && o_stop && waiting_q == FRAMES[BITS-1:0]);
        cover ($past(o_disable) && !o_disable && f_waiting_q != NONE);
`endif
    end
end
