// SPDX-License-Identifier: Apache-2.0
localparam [35:0] F_CLOCKS_PER_MS = {4'd0, CLOCKS_PER_MS[31:0]};
reg        f_reset_seen_q, f_expired_q;
reg [35:0] f_quiet_q;  // clocks since the last kick, or since there was anything to watch
initial f_reset_seen_q = 1'b0;
wire [35:0] f_limit = {20'd0, o_milliseconds} * F_CLOCKS_PER_MS;
always @(posedge clk) begin
    f_reset_seen_q <= f_reset_seen_q || rst;
    f_expired_q    <= o_expired && !rst;
    f_quiet_q      <= rst || i_set || i_kick || !i_running || o_milliseconds == 16'd0 ? 36'd0 : f_quiet_q + 1'b1;
    // After an expiry the outputs are disabled in the next clock, unless a command in this one enabled them anew.
`ifdef FORMAL_WATCHDOG
    assume (!i_set || i_milliseconds < 16'd4);
    if (f_reset_seen_q && f_expired_q && f_quiet_q != 36'd0) assume (!i_running);
    if (f_reset_seen_q) assert (o_milliseconds < 16'd4);
`else
    if (f_reset_seen_q && f_expired_q && f_quiet_q != 36'd0) assert (!i_running);
`endif
    if (f_reset_seen_q) begin
        assert (o_expired == (f_quiet_q != 36'd0 && f_quiet_q == f_limit));
        assert (f_quiet_q <= f_limit + {35'd0, f_expired_q} && clock_q <= LAST_CLOCK);
        assert (f_quiet_q == {20'd0, o_milliseconds - left_q} * F_CLOCKS_PER_MS + {{(36-CLOCK_BITS){1'b0}}, clock_q});
        assert (left_q <= o_milliseconds && (left_q != 16'd0 || o_expired || f_expired_q || o_milliseconds == 16'd0));
        cover (o_expired && o_milliseconds == 16'd3);
        cover (i_kick && f_quiet_q == f_limit - 1'b1 && f_limit > 36'd2);
    end
end
