// SPDX-License-Identifier: Apache-2.0
// One frame, any one, is followed from its first byte until it is done: if outputs were switched off meanwhile, by whatever, o_disable
// is high when its turn comes. The same is said with a list, in both directions: a bit for each frame that waits, oldest first.
`ifdef FORMAL_URGENT_COMMANDS
(* anyseq *) wire f_pick;
`else
wire f_pick = 1'b0;
`endif
localparam [1:0] F_NONE = 2'd0, F_ARRIVES = 2'd1, F_WAITS = 2'd2, F_DONE = 2'd3;
reg [1:0]        f_state_q;
reg [BITS-1:0]   f_ahead_q;    // frames in front of it
reg              f_off_since_q, f_stop_since_q;
reg [FRAMES-1:0] f_stale_q, f_unplayed_q;
reg [BITS-1:0]   f_waiting_q;
reg [7:0]        f_second_q, f_bytes_q;  // of the frame that arrives
reg              f_begun_q, f_old_q, f_reset_seen_q;
initial {f_reset_seen_q, f_state_q} = 3'b000;
wire f_acts    = i_right && f_bytes_q == 8'd4;
wire f_disable = f_acts && f_second_q == `HG_COMMAND_DISABLE;
wire f_stop    = i_stops || (f_acts && f_second_q == `HG_COMMAND_STOP);
wire f_off     = i_off || f_disable;
wire [BITS-1:0]   f_kept  = f_waiting_q - {{(BITS-1){1'b0}}, i_done};
wire [BITS-1:0]   f_waiting_d = f_kept + {{(BITS-1){1'b0}}, i_good};
wire [FRAMES-1:0] f_all   = ~({FRAMES{1'b1}} << f_waiting_d);
wire [FRAMES-1:0] f_place = {{(FRAMES-1){1'b0}}, i_good && f_old_q} << f_kept;
wire f_first = i_arrives && !i_end && !f_begun_q && f_pick;
always @(posedge clk) begin
    f_reset_seen_q <= f_reset_seen_q || rst;
    if (i_valid && f_bytes_q == 8'd1) f_second_q <= i_byte;
    if (rst) begin
        {f_stale_q, f_unplayed_q, f_waiting_q, f_bytes_q, f_begun_q, f_old_q} <= {(2*FRAMES+BITS+10){1'b0}};
        {f_state_q, f_off_since_q, f_stop_since_q} <= {F_NONE, 2'b00};
    end else begin
        if (i_end) f_bytes_q <= 8'd0;
        else if (i_valid && f_bytes_q != 8'hff) f_bytes_q <= f_bytes_q + 1'b1;
        f_begun_q    <= !i_end && (f_begun_q || i_arrives);
        f_old_q      <= !i_end && (f_old_q || (i_off && (f_begun_q || i_arrives)));
        f_waiting_q  <= f_waiting_d;
        f_stale_q    <= f_off ? f_all : (f_stale_q >> i_done) | f_place;
        f_unplayed_q <= f_stop ? f_all : f_unplayed_q >> i_done;
        case (f_state_q)
            F_NONE: if (f_first) {f_state_q, f_off_since_q, f_stop_since_q} <= {F_ARRIVES, f_off, 1'b0};
            F_ARRIVES: begin
                f_off_since_q  <= f_off_since_q || f_off;
                f_stop_since_q <= f_stop && i_end;
                if (i_end) {f_state_q, f_ahead_q} <= {i_good ? F_WAITS : F_NONE, f_kept};
            end
            F_WAITS: begin
                f_off_since_q  <= f_off_since_q || f_off;
                f_stop_since_q <= f_stop_since_q || f_stop;
                if (i_done && f_ahead_q == NONE) f_state_q <= F_DONE;
                else if (i_done) f_ahead_q <= f_ahead_q - 1'b1;
            end
            default: ;
        endcase
    end
`ifdef FORMAL_URGENT_COMMANDS
    assume (!i_right || i_end);
    assume (!i_good || i_right);
    assume (!i_end || (!i_valid && i_arrives));
    assume (!i_valid || i_arrives);
    assume (!i_done || f_waiting_q != NONE);
    assume (!i_good || f_waiting_q < FRAMES[BITS-1:0]);
    assume (f_reset_seen_q || rst);
`endif
    if (f_reset_seen_q) begin
        // What was sent before a switch-off finds o_disable high when its turn comes; before a STOP, o_stop.
        if (f_state_q == F_WAITS && f_off_since_q) assert (o_disable);
        if (f_state_q == F_WAITS && f_stop_since_q) assert (o_stop);
        if (!$past(rst)) assert (o_disable == (f_stale_q != {FRAMES{1'b0}} || $past(f_off)));
        if (!$past(rst)) assert (o_stop == (f_unplayed_q != {FRAMES{1'b0}} || $past(f_stop)));
        if (!$past(rst) && !$past(o_stop) && o_stop) assert (o_stops);
        if (!$past(rst) && $past(f_unplayed_q) != {FRAMES{1'b0}} && f_unplayed_q == {FRAMES{1'b0}}) assert (o_stops);
        if (!$past(rst)) assert (o_heard == $past(f_disable || f_stop));
        assert (f_waiting_q <= FRAMES[BITS-1:0] && waiting_q == f_waiting_q);
`ifdef FORMAL_URGENT_COMMANDS
        assert (f_stale_q == ~({FRAMES{1'b1}} << disable_left_q) && f_unplayed_q == ~({FRAMES{1'b1}} << stop_left_q));
        assert (disable_left_q <= waiting_q && stop_left_q <= waiting_q);
        assert (disable_left_q == NONE || o_disable);
        assert (stop_left_q == NONE || o_stop);
        assert (f_state_q != F_WAITS || f_ahead_q < waiting_q);
        assert (f_state_q != F_WAITS || !f_off_since_q || f_ahead_q < disable_left_q);
        assert (f_state_q != F_WAITS || !f_stop_since_q || f_ahead_q < stop_left_q);
        assert (f_state_q != F_ARRIVES || (f_begun_q && !f_stop_since_q && (!f_off_since_q || f_old_q)));
        assert (!old_q || disable_left_q == waiting_q);
        assert (begun_q == f_begun_q && old_q == f_old_q && (f_begun_q || f_bytes_q == 8'd0));
        assert (count_q == (f_bytes_q > 8'd5 ? 3'd5 : f_bytes_q[2:0]));
        assert (f_bytes_q < 8'd2 || {disables_q, stops_q} == {f_second_q == `HG_COMMAND_DISABLE, f_second_q == `HG_COMMAND_STOP});
        cover (o_disable && o_stop && waiting_q == FRAMES[BITS-1:0]);
        cover ($past(o_disable) && !o_disable && f_waiting_q != NONE);
        cover (f_state_q == F_DONE && f_off_since_q && !o_disable);
        cover (o_disable && $past(i_good && old_q) && !$past(o_disable));
        cover (o_heard && !$past(i_good));
`endif
    end
end
