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
always @(posedge clk) begin
    f_reset_seen_q <= f_reset_seen_q || rst;
    if (i_push && write_q == f_place) f_entry_q <= i_entry;
    if (f_reset_seen_q && !rst && !i_clear) begin
`ifdef FORMAL_LIVE_FIFO
        assume (!i_push || o_free != 16'd0);
        assume (!i_push || (!i_keep && !i_take_back));
        assume (!i_keep || !i_take_back);
`else
        assert (!i_push || o_free != 16'd0);
        assert (!i_push || (!i_keep && !i_take_back));
        assert (!i_keep || !i_take_back);
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
            if ($past(level != 0 && !i_take)) assert (o_valid);
        end
        cover (o_valid && i_take && read_q == f_place && level == PLACES[BITS:0]);
        cover (i_take_back && o_free == 16'd0 && level != 0 && !rst && !i_clear);
        cover (o_valid && o_entry != 0 && $past(i_take) && $past(o_valid));
    end
end
