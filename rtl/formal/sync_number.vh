// SPDX-License-Identifier: Apache-2.0
// Against a master that is described here a second time: whenever the count is changed, it becomes the master's number; and a count
// that counts as confirmed is the master's, as long as the wire says nothing but the truth. Any symbol may get lost.
reg f_past_q;  // there was a clock before this one, and in simulation a reset
initial f_past_q = 1'b0;
wire [5:0] f_next = i_count[5:0] + 6'd1;
`ifdef FORMAL_SYNC_NUMBER
(* anyseq *) wire f_lost;
(* anyconst *) wire f_truthful;  // or the wire says anything at all
reg  [47:0] f_master_q, f_count_q;
wire [5:0]  f_place = f_master_q[5:0] + 6'd1;
wire        f_bit = f_place <= 6'd42 ? f_master_q[6'd48 - f_place] : f_place == 6'd43 && ^f_master_q[47:6];
// What has been heard of the master's number so far.
wire [5:0]  f_heard = place_q > 6'd43 ? 6'd42 : place_q - 6'd1;
wire [41:0] f_so_far = f_master_q[47:6] >> (6'd42 - f_heard), f_those = ~(42'h3ff_ffff_ffff << f_heard);
always @(posedge clk) begin
    f_past_q   <= 1'b1;
    f_master_q <= f_master_q + {47'd0, i_valid};
    f_count_q  <= (o_load ? o_value : f_count_q) + {47'd0, i_valid};
    assume (i_count == f_count_q);
    // Any state that the assertions allow may be the first one: the middle of a message, for example.
    if (!f_past_q && f_truthful) assume (!within_q || (place_q == f_place && (place_q == 6'd0 || place_q > 6'd43
                                                                || ((upper_q & f_those) == f_so_far && odd_q == ^f_so_far))));
    if (!f_past_q && f_truthful) assume (!within_q || place_q <= 6'd43 || upper_q == f_master_q[47:6]);
    if (!f_past_q && f_truthful) assume (!o_agreed || i_count == f_master_q);
    if (i_valid && f_truthful) assume (i_symbol == (f_lost ? 2'd3 : f_place == 6'd0 ? 2'd2 : {1'b0, f_bit}));
    if (f_past_q && f_truthful) begin
        if (within_q) assert (place_q == f_place);
        if (within_q && place_q != 6'd0 && place_q <= 6'd43) assert ((upper_q & f_those) == f_so_far && odd_q == ^f_so_far);
        if (o_load) assert (o_value == f_master_q);
        if (o_agreed) assert (i_count == f_master_q);
        cover (o_load);
        cover (o_agreed && !$past(o_agreed));
    end
end
`endif
always @(posedge clk) begin
`ifndef FORMAL_SYNC_NUMBER
    f_past_q <= f_past_q || rst;
`endif
    if (f_past_q) begin
        assert (o_symbol == (f_next == 6'd0 ? 2'd2 : f_next > 6'd43 ? 2'd0 : f_next == 6'd43 ? {1'b0, ^i_count[47:6]}
                             : {1'b0, i_count[6'd48 - f_next]}));
        // A number that was confirmed is not changed by one message that says another, but by the second.
        assert (!o_load || !o_agreed);
        if ($past(o_agreed) && !$past(rst) && !o_agreed) assert ($past(whole && !agrees));
        if (!$past(o_agreed) && o_agreed) assert ($past(whole && agrees));
        cover (o_symbol == 2'd2);
`ifdef FORMAL_SYNC_NUMBER
        cover (!o_agreed && $past(o_agreed) && !$past(rst));
`endif
    end
end
