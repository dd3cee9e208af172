// SPDX-License-Identifier: Apache-2.0
// The periods since the last reset or load are counted a second way, in bits that toggle: none is skipped, none comes twice.
reg        f_reset_seen_q;
reg [3:0]  f_base_q;
reg [3:0]  f_since_q;  // as a ripple of toggling bits, modulo 16
initial f_reset_seen_q = 1'b0;
wire [3:0] f_gone = o_count[3:0] - f_base_q[3:0];
always @(posedge clk) begin
    f_reset_seen_q <= f_reset_seen_q || rst;
    if (rst || i_load) begin
        f_base_q  <= rst ? 4'd0 : i_value[3:0];
        f_since_q <= 4'd0;
    end else if (i_period) begin
        f_since_q[0] <= !f_since_q[0];
        f_since_q[1] <= f_since_q[1] ^ f_since_q[0];
        f_since_q[2] <= f_since_q[2] ^ (&f_since_q[1:0]);
        f_since_q[3] <= f_since_q[3] ^ (&f_since_q[2:0]);
    end
    if (f_reset_seen_q) begin
        assert (f_gone == f_since_q);
        if (!$past(rst || i_load)) assert (o_count - $past(o_count) <= 48'd1);
        if (!$past(rst || i_load || i_period)) assert (o_count == $past(o_count));
        cover (f_since_q == 4'd2 && f_base_q == 4'hf);
        cover (o_count == 48'd3);
    end
end
