// SPDX-License-Identifier: Apache-2.0
// What square_root promises: the largest whole number whose square is not above the radicand, STAGES used clocks later. The rest is
// the difference, so a stage that loses a bit of it is seen, too.
reg  [2*BITS*STAGES-1:0] f_radicands_q;
reg  [7:0]               f_clocks_q;
wire [2*BITS-1:0]        f_radicand = f_radicands_q[2*BITS*STAGES-1 -: 2*BITS];
wire [2*BITS+1:0]        f_wide     = {2'b00, f_radicand};
wire [2*BITS+1:0]        f_root     = {{(BITS+1){1'b0}}, root[STAGES]};
wire [2*BITS+1:0]        f_rest     = {{(BITS+1){1'b0}}, rest[STAGES]};
initial f_clocks_q = 8'd0;
always @(posedge clk) begin
    f_radicands_q <= {f_radicands_q[2*BITS*(STAGES-1)-1:0], i_radicand};
    if (!i_used) f_clocks_q <= 8'd0;
    else if (f_clocks_q != STAGES[7:0]) f_clocks_q <= f_clocks_q + 8'd1;
    if (f_clocks_q == STAGES[7:0]) begin
        assert (f_root * f_root <= f_wide && (f_root + 1'b1) * (f_root + 1'b1) > f_wide);
        assert (f_rest == f_wide - f_root * f_root && f_rest <= f_root << 1);
        cover (&f_radicand);
        cover (f_root != 0 && f_rest == 0);
        cover (f_root != 0 && f_rest == f_root << 1);
    end
end
