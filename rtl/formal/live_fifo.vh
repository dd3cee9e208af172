// SPDX-License-Identifier: Apache-2.0
reg f_reset_seen_q;
initial f_reset_seen_q = 1'b0;
// Any one place is followed: what was pushed there is what comes out when its turn comes.
`ifdef FORMAL_LIVE_FIFO
(* anyconst *) wire [BITS:0] f_place;
`else
wire [BITS:0] f_place = {(BITS+1){1'b0}};
`endif
reg [31:0]    f_entry_q;
wire [BITS:0] f_ahead = f_place - read_q;  // entries before it
// While it is closed, the entries from the mark on are not read.
reg f_closed_q;
wire [BITS:0] f_before_mark = mark_q - read_q;
always @(posedge clk) begin
    f_closed_q <= !rst && !i_clear && (i_mark || (f_closed_q && i_closed));
    f_reset_seen_q <= f_reset_seen_q || rst;
    if (i_push && write_q == f_place) f_entry_q <= i_entry;
    if (f_reset_seen_q && !rst && !i_clear) begin
`ifdef FORMAL_LIVE_FIFO
        assume (!i_push || o_free != 16'd0);
        assume (!i_push || (!i_keep && !i_take_back));
        assume (!i_keep || !i_take_back);
        assume (!i_mark || (i_keep && !i_closed));
        assume (!i_closed || f_closed_q);
`else
        assert (!i_push || o_free != 16'd0);
        assert (!i_push || (!i_keep && !i_take_back));
        assert (!i_keep || !i_take_back);
        assert (!i_mark || (i_keep && !i_closed));
`endif
    end
    if (f_reset_seen_q) begin
        assert (used <= PLACES[BITS:0] && level <= used);
        assert (!o_valid || level != {(BITS+1){1'b0}});
        if (f_ahead < used) assert (entries[f_place[BITS-1:0]] == f_entry_q);
        if (o_valid) assert (o_entry == entries[read_q[BITS-1:0]]);
        if (o_valid && read_q == f_place) assert (o_entry == f_entry_q);
        // A provisional entry is never read. i_keep makes it readable, i_take_back removes it, both in the next clock.
        if ($past(rst || i_clear)) begin
            assert (used == 0 && !o_valid);
        end else begin
            if ($past(o_valid && !i_take)) begin assert (o_valid && o_entry == $past(o_entry)); end
            assert (read_q == $past(read_q) + {{BITS{1'b0}}, $past(o_valid && i_take)});
            assert (write_q == $past(i_take_back ? kept_q : write_q) + {{BITS{1'b0}}, $past(i_push)});
            assert (kept_q == $past(i_keep ? write_q : kept_q));
            if ($past(level != 0 && !i_take && !i_closed)) assert (o_valid);
            if ($past(i_closed) && o_valid) assert (read_q != mark_q);
            if (i_closed && f_closed_q) assert (f_before_mark <= level);
`ifdef FORMAL_LIVE_FIFO
            if ($past(i_closed && f_before_mark != 0 && !i_take)) assert (o_valid);
`endif
        end
        cover (o_valid && i_take && read_q == f_place && level == PLACES[BITS:0]);
        cover (i_take_back && o_free == 16'd0 && level != 0 && !rst && !i_clear);
`ifdef FORMAL_LIVE_FIFO
        cover (i_closed && !o_valid && level == 2);
        cover ($past(i_closed) && !i_closed && level == 2 && !$past(rst || i_clear));
`endif
        cover (o_valid && o_entry != 0 && $past(i_take) && $past(o_valid));
    end
end
