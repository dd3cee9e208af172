// SPDX-License-Identifier: Apache-2.0
// Contract 9, said another way than the module does it: the number of the present period since the start, divided by N.
reg f_reset_seen_q;
initial f_reset_seen_q = 1'b0;
always @(posedge clk) f_reset_seen_q <= f_reset_seen_q || rst;

`ifdef FORMAL_MODULATION
`define F_EXPECT assume
`else
`define F_EXPECT assert
`endif
always @(posedge clk) if (f_reset_seen_q && !rst) begin
    `F_EXPECT (!i_period || period_q == 3'd0);
    `F_EXPECT (!i_at_pass_end || i_start || i_stop);
    `F_EXPECT (!i_drop || !(i_start || i_stop));
    `F_EXPECT (!i_period || !starts || {1'b0, i_first, 1'b0} + i_length <= {1'b1, {BITS{1'b0}}});
    `F_EXPECT (!i_period || !starts || (i_divider != 16'd0 && i_length != {(BITS+1){1'b0}} && i_length <= {1'b1, {BITS{1'b0}}}));
    `F_EXPECT (!i_write || !o_fetching);
end
`undef F_EXPECT

`ifdef FORMAL_MODULATION
// Any one word of the memory is followed.
(* anyconst *) wire [BITS-2:0] f_address;
reg [15:0] f_word_q;
reg        f_written_q;
initial f_written_q = 1'b0;
// The record of the start: its settings, the number of the period since, and what the period's number says about the sample.
reg        f_on_q, f_loop_q;
reg [BITS:0] f_length_q;
reg [BITS-1:0] f_first_q;
reg [15:0] f_divider_q, f_part_q;  // f_period_q = f_quotient_q · N + f_part_q
reg [7:0]  f_period_q, f_quotient_q;
wire [7:0] f_length = {{(7-BITS){1'b0}}, f_length_q};
wire       f_over = f_quotient_q >= f_length;
wire [7:0] f_sample = (!f_over ? f_quotient_q : f_loop_q ? f_quotient_q % f_length : f_length - 8'd1) + {{(8-BITS){1'b0}}, f_first_q};
// The last wish before the period: 0 none, 1 start, 2 stop; and whether it is for the end of the pass.
reg [1:0]  f_wish_q;
reg        f_later_q;
wire [1:0] f_wish = i_stop ? 2'd2 : i_start ? 2'd1 : f_wish_q;
wire       f_later = i_stop || i_start ? i_at_pass_end : f_later_q;
wire       f_last  = {8'd0, f_part_q} + 24'd1 == {8'd0, f_divider_q} && f_quotient_q % f_length == f_length - 8'd1;  // period of its pass
wire       f_now   = i_period && (!f_later || !f_on_q || f_last || (f_over && !f_loop_q));
// What was read of the followed word when the present period's sample was fetched.
reg [15:0] f_fetched_q;
// Whether the present period's sample has been fetched since reset, and the followed word was written before that.
reg f_word_known_q, f_written_before_q;
always @(posedge clk) begin
    if (rst) {f_word_known_q, f_written_before_q} <= 2'b00;
    else if (o_fetching) {f_word_known_q, f_written_before_q} <= {1'b1, f_written_q};
end
always @(posedge clk) begin
    if (i_write && i_write_address == f_address) {f_word_q, f_written_q} <= {i_write_word, 1'b1};
    if (o_fetching) f_fetched_q <= f_word_q;
    f_wish_q  <= rst || f_now || i_drop ? 2'd0 : f_wish;
    f_later_q <= f_later;
    if (rst) f_on_q <= 1'b0;
    else if (f_now && f_wish == 2'd1) begin
        {f_on_q, f_loop_q, f_length_q, f_first_q, f_divider_q} <= {1'b1, i_loop, i_length, {i_first, 1'b0}, i_divider};
        {f_period_q, f_quotient_q, f_part_q} <= 32'd0;
    end else if (f_now && f_wish == 2'd2) f_on_q <= 1'b0;
    else if (i_period) begin
        f_period_q   <= f_period_q + 8'd1;
        f_quotient_q <= f_part_q + 16'd1 == f_divider_q ? f_quotient_q + 8'd1 : f_quotient_q;
        f_part_q     <= f_part_q + 16'd1 == f_divider_q ? 16'd0 : f_part_q + 16'd1;
    end
    // A number that fits the counters above; contract 9 for longer plays follows from the invariants by induction on the quotient.
    if (f_reset_seen_q) assume (f_period_q != 8'hff);
    if (f_written_q) assert (words[f_address] == f_word_q);
    if (f_reset_seen_q) begin
        assert (f_wish_q == {stops_q, starts_q} && f_wish_q != 2'd3);
        assert (f_wish_q == 2'd0 || f_later_q == at_pass_end_q);
        assert (plays_q == f_on_q);
        if (f_on_q) begin
            assert (loop_q == f_loop_q && divider_q == f_divider_q && f_divider_q != 16'd0 && f_length_q != 0 && f_length_q <= {1'b1, {BITS{1'b0}}});
            assert ({1'b0, f_first_q} + f_length_q <= {1'b1, {BITS{1'b0}}} && first_q == f_first_q);
            assert (last_q == f_first_q + f_length_q[BITS-1:0] - 1'b1);
            assert (f_part_q < f_divider_q && f_quotient_q <= f_period_q && {8'd0, f_part_q} <= {16'd0, f_period_q});
            assert (ended_q == (f_over && !f_loop_q));
            assert (sample_q == f_sample[BITS-1:0]);
            assert (ended_q || left_q == f_divider_q - f_part_q);
            if (period_q == 3'd0 && f_word_known_q && f_written_before_q && sample_q[BITS-1:1] == f_address)
                assert (o_sample == (sample_q[0] ? f_fetched_q[15:8] : f_fetched_q[7:0]));
        end
        if (period_q == 3'd0 && !f_on_q) assert (o_sample == 8'hff);
        if (period_q == 3'd0) assert (o_running == (f_on_q && !(f_over && !f_loop_q)));
        if (!$past(rst) && !$past(period_q[3])) assert (o_sample == $past(o_sample) && o_running == $past(o_running));
        cover (f_on_q && f_loop_q && f_quotient_q == 8'd3 && f_length_q == 3 && f_divider_q == 16'd2 && period_q == 3'd0);
        cover (f_on_q && f_over && !f_loop_q && o_sample == 8'h5a && sample_q[BITS-1:1] == f_address && f_written_before_q);
        cover (f_on_q && f_first_q != 0 && f_period_q == 8'd0 && $past(f_on_q) && $past(f_last) && $past(f_wish_q) == 2'd1 && $past(f_later_q));
        cover (!f_on_q && $past(f_on_q) && !$past(rst));
        cover (f_on_q && f_period_q == 8'd0 && $past(f_on_q) && $past(f_period_q) == 8'd2);
    end
end
`endif
