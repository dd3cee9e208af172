// SPDX-License-Identifier: Apache-2.0
//
// focus_engine grants a start exactly when all foci of all channels of the last one have been counted through, or after a reset.
// When the results come, and how many, is tested in simulation: 33 clocks of pipeline are too long for the solver.
`default_nettype none
module focus_starts (
    input wire       clk,
    input wire       rst,
    input wire       i_start,
    input wire [2:0] i_last_focus
);
    wire ready, valid, last, channel;
    focus_engine #(.CHANNELS(2)) engine (
        .clk(clk), .rst(rst), .i_geometry(1'b0), .i_geometry_address(3'd0), .i_geometry_word(16'd0),
        .i_focus(1'b0), .i_focus_address(5'd0), .i_focus_word(16'd0),
        .i_start(i_start), .o_ready(ready), .i_last_focus(i_last_focus), .i_whole(1'b0), .i_wave_number(18'd0), .i_gain(16'd0),
        .o_valid(valid), .o_last(last), .o_far(), .o_channel(channel), .o_phase(), .o_amplitude());

    reg       f_reset_seen_q;
    reg [4:0] f_left_q;  // clocks that the last start still takes
    initial f_reset_seen_q = 1'b0;
    always @(posedge clk) begin
        f_reset_seen_q <= f_reset_seen_q || rst;
        if (rst) f_left_q <= 5'd0;
        else if (i_start && ready) f_left_q <= {1'b0, i_last_focus, 1'b0} + 5'd2;
        else if (f_left_q != 5'd0) f_left_q <= f_left_q - 5'd1;
        if (f_reset_seen_q) begin
            assert (ready == (f_left_q <= 5'd1));
            assert (last == (valid && channel));
            cover (i_start && ready && f_left_q == 5'd1 && $past(f_left_q) == 5'd2);
            cover (f_left_q == 5'd7 && rst);
        end
    end
endmodule
`default_nettype wire
