// SPDX-License-Identifier: Apache-2.0
// One frame, any one, is followed from the moment in which it, or what may be its first byte, begins to arrive until it is done: if it happened
// meanwhile, beside the frames or by one of them, or if its bytes came out of the port as old ones, o_old is high when its turn comes.
// The same is said with a list, in both directions: a bit for each frame that waits, oldest first.
`ifdef FORMAL_OLD_FRAMES
(* anyseq *) wire f_pick;
`else
wire f_pick = 1'b0;
`endif
localparam [1:0] F_NONE = 2'd0, F_ARRIVES = 2'd1, F_WAITS = 2'd2, F_DONE = 2'd3;
reg [1:0]          f_state_q;
reg [BITS-1:0]     f_ahead_q;    // frames in front of it
reg                f_since_q;
reg [FRAMES-1:0] f_list_q;
reg [BITS-1:0]     f_waiting_q;
reg                f_begun_q, f_arriving_q, f_held_q, f_reset_seen_q;  // f_arriving_q: what arrives is old
initial {f_reset_seen_q, f_state_q} = 3'b000;
wire f_happens = i_event || i_acts || i_old;
wire [BITS-1:0]     f_kept = f_waiting_q - {{(BITS-1){1'b0}}, i_done};
wire [BITS-1:0]     f_waiting_d = f_kept + {{(BITS-1){1'b0}}, i_good};
wire [FRAMES-1:0] f_all   = ~({FRAMES{1'b1}} << f_waiting_d);
wire [FRAMES-1:0] f_place = {{(FRAMES-1){1'b0}}, i_good && f_arriving_q} << f_kept;
wire [FRAMES-1:0] f_list_d = f_happens || (i_good && f_arriving_q) ? f_all : (f_list_q >> i_done) | f_place;
wire f_first = i_begun && !i_end && !f_begun_q && f_pick;
always @(posedge clk) begin
    f_reset_seen_q <= f_reset_seen_q || rst;
    if (rst) begin
        {f_list_q, f_waiting_q, f_begun_q, f_arriving_q, f_held_q} <= {(FRAMES+BITS+3){1'b0}};
        {f_state_q, f_since_q} <= {F_NONE, 1'b0};
    end else begin
        f_begun_q    <= !i_end && i_begun;
        f_arriving_q <= !i_end && i_begun && (f_arriving_q || i_event || i_old || i_near);
        f_held_q     <= i_old;
        f_waiting_q  <= f_waiting_d;
        f_list_q     <= f_list_d;
        case (f_state_q)
            F_NONE: if (f_first) {f_state_q, f_since_q} <= {F_ARRIVES, i_event || i_old || i_near};
            F_ARRIVES: begin
                f_since_q <= f_since_q || f_happens;
                if (i_end) {f_state_q, f_ahead_q} <= {i_good ? F_WAITS : F_NONE, f_kept};
                else if (!i_begun) f_state_q <= F_NONE;
            end
            F_WAITS: begin
                f_since_q <= f_since_q || f_happens;
                if (i_done && f_ahead_q == NONE) f_state_q <= F_DONE;
                else if (i_done) f_ahead_q <= f_ahead_q - 1'b1;
            end
            default: ;
        endcase
    end
`ifdef FORMAL_OLD_FRAMES
    assume (!i_good || i_end);
    assume (!i_acts || i_end);
    assume (!i_end || i_begun);
    assume (!i_good || f_begun_q);
    assume (!i_done || f_waiting_q != NONE);
    assume (!i_good || f_waiting_q < FRAMES[BITS-1:0]);
    assume (i_waiting == f_waiting_d);
    assume (f_reset_seen_q || rst);
`endif
    if (f_reset_seen_q) begin
        if (f_state_q == F_WAITS && f_since_q) assert (o_old);
        if (!$past(rst)) assert (o_old == (f_list_q != {FRAMES{1'b0}} || $past(f_happens)));
        // The end strobes once, when nothing is old any more.
        if (f_list_q != {FRAMES{1'b0}} && f_list_d == {FRAMES{1'b0}} && !f_happens) assert (o_ends);
        if (o_ends) assert (o_old && !f_happens && f_list_d == {FRAMES{1'b0}});
        if (!$past(rst) && $past(o_ends)) assert (!o_old);
        assert (f_waiting_q <= FRAMES[BITS-1:0]);
`ifndef FORMAL_OLD_FRAMES
        assert (i_waiting == f_waiting_d);
`endif
        assert (f_list_q == ~({FRAMES{1'b1}} << left_q) && left_q <= f_waiting_q);
        assert (left_q == NONE || o_old);
        assert (f_held_q == held_q && (!held_q || o_old) && f_arriving_q == old_q);
        assert (!old_q || f_begun_q);
        assert (f_state_q != F_WAITS || f_ahead_q < f_waiting_q);
        assert (f_state_q != F_WAITS || !f_since_q || f_ahead_q < left_q);
        assert (f_state_q != F_ARRIVES || (f_begun_q && (!f_since_q || old_q)));
`ifdef FORMAL_OLD_FRAMES
        cover (o_old && f_waiting_q == FRAMES[BITS-1:0]);
        cover (o_ends && f_waiting_q != NONE);
        cover (o_ends && f_state_q == F_DONE && f_since_q && $past(i_old));
        cover (f_state_q == F_DONE && f_since_q && !o_old);
        cover (o_old && $past(i_good && old_q) && !$past(o_old));
        cover ($past(old_q) && !old_q && !$past(i_end) && !$past(rst));
`endif
    end
end
