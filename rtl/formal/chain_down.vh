// SPDX-License-Identifier: Apache-2.0
// Whatever bytes came before, a zero is passed on as a zero and nothing else is, so that every tile sees the same frames end.
// And the two bytes of a frame for all, which follow a zero, are passed on as they are.
reg       f_reset_seen_q, f_ones_q, f_passed_q;  // a bit of this byte was 1, as it came and as it was passed on
reg       f_same_q;                              // all bits so far were passed on as they came
reg [1:0] f_all_q;                               // bytes of a frame for all since the last zero
initial f_reset_seen_q = 1'b0;
wire f_data = sample && bits_left != START && bits_left != STOP;
always @(posedge clk) begin
    f_reset_seen_q <= f_reset_seen_q || rst;
    if (sample && bits_left == START) {f_ones_q, f_passed_q, f_same_q} <= 3'b001;
    if (f_data) {f_ones_q, f_passed_q, f_same_q} <= {f_ones_q || i_line, f_passed_q || counted, f_same_q && i_line == counted};
    if (rst || misframed || (complete && value == 8'd0)) f_all_q <= 2'd0;
    else if (complete && f_all_q != 2'd3)
        f_all_q <= f_all_q == 2'd0 && value == `HG_CHAIN_ALL ? 2'd1 : f_all_q == 2'd1 && value == `HG_CHAIN_COMPLEMENT ? 2'd2 : 2'd3;
    if (f_reset_seen_q && !rst) begin
        assert (bits_left <= START && (f_all_q != 2'd0 || place_q == FIRST));
        if (bits_left != IDLE && bits_left < LOWEST) begin
            assert (f_ones_q == f_passed_q && f_ones_q == (value >> (bits_left - 4'd1) != 8'd0));
            assert (!header || ((!carry_q || (f_ones_q && counts_q)) && (counts_q || f_same_q)));
            if (place_q == FIRST) assert (counts_q == value[bits_left[2:0] - 3'd1]);
            if (!header) assert (f_same_q);
        end
        if (bits_left == LOWEST) assert (!f_ones_q && !f_passed_q && f_same_q);
        // What a frame for all begins with is not counted, and neither is what follows it.
        if (f_all_q == 2'd1) assert (place_q == SECOND && !counts_q && near_q);
        if (f_all_q == 2'd2) assert (!header && mine_q);
        if (complete && f_all_q != 2'd3 && value == `HG_CHAIN_ALL && place_q == FIRST) assert (f_same_q);
        if (complete && f_all_q != 2'd0 && f_all_q != 2'd3) assert (f_same_q);
        cover (sample && bits_left == LOWEST && place_q == SECOND && counts_q && !i_line);
        cover (f_all_q == 2'd1);
    end
end
