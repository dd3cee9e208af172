// SPDX-License-Identifier: Apache-2.0
// After a zero byte, or a break, the next frame is decoded rightly, whatever came before.
reg f_reset_seen_q;
initial f_reset_seen_q = 1'b0;
always @(posedge clk) begin
    f_reset_seen_q <= f_reset_seen_q || rst;
    assert (!(o_valid && o_end));
    if (f_reset_seen_q) begin
        if ($past(rst || o_end || i_break)) assert (o_intact && !o_valid);
        if ($past(!rst && !i_break && i_valid && i_byte > 8'd1 && o_intact)) assert (!o_intact);
        cover (o_end && !o_intact);
        cover (o_end && o_intact && !$past(rst || o_end));
    end
end
