// SPDX-License-Identifier: Apache-2.0
// A break is the CLOCKS-th clock in a row in which the line is low, after one in which it was high.
reg [31:0] f_low_q;  // clocks the line has been low, since it was high
reg        f_high_seen_q, f_reset_seen_q;
reg [1:0]  f_reset_ago_q;  // clocks
initial f_reset_seen_q = 1'b0;
always @(posedge clk) begin
    f_reset_seen_q <= f_reset_seen_q || rst;
    if (rst) f_reset_ago_q <= 2'd0;
    else if (f_reset_ago_q != 2'd2) f_reset_ago_q <= f_reset_ago_q + 1'b1;
    if (rst || f_reset_ago_q != 2'd2) f_high_seen_q <= 1'b0;
    else if (i_line) {f_high_seen_q, f_low_q} <= {1'b1, 32'd0};
    else if (f_low_q != 32'hffff_ffff) f_low_q <= f_low_q + 1'b1;
    if (f_reset_seen_q) begin
        assert (f_reset_ago_q != 2'd3 && (f_reset_ago_q == 2'd2 || !f_high_seen_q));
        assert ((old_q != 2'b00) == (f_reset_ago_q != 2'd2) && (f_reset_ago_q != 2'd1 || old_q == 2'b10) && (f_reset_ago_q != 2'd0 || old_q[0]));
        assert (low_q == (!f_high_seen_q || f_low_q >= CLOCKS ? LAST : f_low_q[BITS-1:0]));
        assert (o_break == ($past(!rst && !i_line && f_high_seen_q) && f_low_q == CLOCKS));
        cover (o_break);
    end
end
