// SPDX-License-Identifier: Apache-2.0
// Contract 10: what waits for a period begins neither before it nor twice, what a PUSH has begun is kept whole or not at all.
`ifdef FORMAL_SCHEDULE
(* anyseq *) wire f_clears;  // any clock may be one in which something else empties the FIFO
`endif
reg f_reset_seen_q;
initial f_reset_seen_q = 1'b0;
reg [47:0] f_start_gate_q, f_live_gate_q;  // the periods that were named for what waits
reg        f_broken_q;                     // the FIFO was emptied since the first index of the present PUSH
reg        f_begun_q;                      // it has begun
always @(posedge clk) begin
    f_reset_seen_q <= f_reset_seen_q || rst;
    if (i_start) f_start_gate_q <= gate_q;
    if (o_mark) f_live_gate_q <= gate_q;
    f_begun_q  <= !rst && !i_keep && !i_take_back && (f_begun_q || i_push);
    f_broken_q <= !rst && !i_keep && !i_take_back && (f_broken_q || (i_clear && (f_begun_q || i_push)));
    if (f_reset_seen_q && !rst) begin
`ifdef FORMAL_SCHEDULE
        assume ({3'd0, i_gate} + {3'd0, i_select} + {3'd0, i_start} + {3'd0, i_modulate} + {3'd0, i_push} + {3'd0, i_keep} + {3'd0, i_take_back}
                + {3'd0, i_forget && !i_take_back} <= 4'd1);
        assume (!i_gate || !o_busy);
        assume (!(i_push || i_keep) || !o_no_push);
        assume (!i_gate || $past({i_argument_2, i_argument_1, i_argument_0}) == named);
        assume (i_clear == (i_select || o_start || i_stop || f_clears));
`else
        assert (!i_gate || !o_busy);
`endif
    end
    if (f_reset_seen_q) begin
        if (start_q) assert (gate_q == f_start_gate_q);
        if (live_q) assert (gate_q == f_live_gate_q);
        assert (!(start_q && follow_q));
        assert (!(live_q && by_trigger));
        assert (cut_q == f_broken_q && pushing_q == f_begun_q);
        if (!$past(rst) && !rst) begin
            // Not before the period before, and then at once.
            if (fires) assert (by_trigger ? $past(i_trigger) && !i_off : $past(i_count) + 48'd1 >= f_start_gate_q);
            if (modulates && by_trigger) assert ($past(i_trigger) && !i_off);
            // What waits for the trigger is gone with the outputs.
            if ($past(i_off && by_trigger)) assert (!start_q && !modulate_q);
            if (live_q && o_live) assert ($past(i_count) + 48'd1 >= f_live_gate_q);
            if ($past(start_q) && !start_q) assert ($past(o_start || i_select || i_stop || i_start || o_live || o_keep || disarms));
            // What a PUSH has kept behind the gate is not emptied by a START that was sent before it.
            if ($past(o_keep && gated && !i_start)) assert (!start_q);
            if ($past(fires)) assert (!start_q);
            if (start_q) assert (!o_start || fires || i_start);
            if ($past(live_q && !reached_q && !i_clear)) assert (o_closed);
        end
        if (o_keep) assert (!f_broken_q);
        if (!rst) assert (!(o_keep && o_take_back));
        if (i_keep || i_take_back) assert (o_keep || o_take_back);
        cover (fires && gate_q == 48'd3 && i_count == 48'd2);
        cover (i_keep && o_take_back);
        cover (o_late);
        cover (live_q && o_live && !$past(rst));
        cover (modulates);
        cover (TRIGGER == 0 || (fires && by_trigger));
        cover (i_followed && o_follow);
    end
end
