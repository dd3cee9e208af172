// SPDX-License-Identifier: Apache-2.0
// Proved together with pulse_generators, which drives the pins: contract 4 is about both (tests/formal/guarded_pulses.v).
localparam [WINDOW_BITS-1:0] F_WINDOW = WINDOW[WINDOW_BITS-1:0];
localparam [WINDOW_BITS-1:0] F_BOUND  = MAX_HIGH_CLOCKS[WINDOW_BITS-1:0];
reg f_past_valid_q, f_reset_seen_q, f_wanted_q, f_any_q, f_off_q;
initial {f_past_valid_q, f_reset_seen_q, f_wanted_q} = 3'b000;
always @(posedge clk) begin
    f_past_valid_q <= 1'b1;
    f_off_q        <= rst || i_disable || o_trip;
    f_any_q        <= i_pins != {CHANNELS{1'b0}};
    f_reset_seen_q <= f_reset_seen_q || rst;
    // Some strobe enabled the outputs and nothing has disabled them since.
    if (rst || i_disable || o_trip) f_wanted_q <= 1'b0;
    else if (i_enable) f_wanted_q <= 1'b1;
    assert (o_enabled == f_wanted_q);
    assert (!o_allow || f_wanted_q);
    if (!f_past_valid_q || !$past(f_wanted_q)) assert (i_pins == {CHANNELS{1'b0}});
    if (f_past_valid_q && f_off_q) assert (i_pins == {CHANNELS{1'b0}});
    if (f_reset_seen_q) assert (window_q < F_WINDOW && (!o_trip || window_q == {WINDOW_BITS{1'b0}}));
    if (f_reset_seen_q && f_past_valid_q && !$past(rst)) assert (o_alive == ($past(o_alive) ^ (window_q == {WINDOW_BITS{1'b0}})));
    cover (f_reset_seen_q && o_trip);
    cover (f_past_valid_q && i_disable && f_any_q);
end

genvar f_k;
generate
    for (f_k = 0; f_k < CHANNELS; f_k = f_k + 1) begin : f_channel
        reg [WINDOW_BITS-1:0]  f_high_q;  // clocks this pin has been high without a break, until the last one
        wire [WINDOW_BITS-1:0] f_high = i_pins[f_k] ? f_high_q + 1'b1 : {WINDOW_BITS{1'b0}};
        initial f_high_q = {WINDOW_BITS{1'b0}};
        always @(posedge clk) begin
            f_high_q <= f_high;
            if (f_reset_seen_q) begin
                assert (f_high <= F_BOUND);
                assert (f_high <= window_q + 1'b1 + (o_trip || stayed_high_q[f_k] ? F_WINDOW : {WINDOW_BITS{1'b0}})
                        + (o_trip ? F_WINDOW : {WINDOW_BITS{1'b0}}));
                cover (f_high == F_BOUND - 1'b1);
            end
        end
    end
endgenerate
