// SPDX-License-Identifier: Apache-2.0
//
// Proves that what goes into cobs_encoder comes out of cobs_decoder: every byte (any one is followed), no more and no fewer. Frames
// have 1 to LONGEST bytes and follow each other without a pause; another proof, of cobs_encoder, says that pauses change nothing.
`default_nettype none
module cobs_roundtrip #(
    parameter BYTES   = 8,
    parameter LONGEST = 5
) (
    input wire       clk,
    input wire       rst,
    input wire [7:0] i_byte,
    input wire       i_last
);
    (* anyconst *) wire [3:0] f_number;

    wire       ready, line_valid, out_valid, out_end, out_intact;
    wire [7:0] line_byte, out_byte;
    cobs_encoder #(.BYTES(BYTES)) encoder (
        .clk(clk), .rst(rst), .i_valid(1'b1), .o_ready(ready), .i_byte(i_byte), .i_last(i_last),
        .o_valid(line_valid), .i_ready(1'b1), .o_byte(line_byte));
    cobs_decoder decoder (
        .clk(clk), .rst(rst), .i_valid(line_valid), .i_byte(line_byte), .i_break(1'b0),
        .o_valid(out_valid), .o_byte(out_byte), .o_end(out_end), .o_intact(out_intact));

    reg       f_reset_seen_q, f_complete_q;
    reg [3:0] f_in_q, f_out_q, f_frames_q;
    reg [7:0] f_byte_q;
    initial f_reset_seen_q = 1'b0;
    always @(posedge clk) begin
        f_reset_seen_q <= 1'b1;
        assume (rst == !f_reset_seen_q);
        assume (i_last || f_in_q < LONGEST - 1);
        if (rst) {f_in_q, f_out_q, f_frames_q, f_complete_q} <= 13'd0;
        else begin
            if (ready) begin
                f_in_q       <= f_in_q + 1'b1;
                f_complete_q <= i_last;
                if (f_in_q == f_number) f_byte_q <= i_byte;
            end
            if (out_valid) f_out_q <= f_out_q + 1'b1;
            if (out_end) {f_in_q, f_out_q, f_frames_q, f_complete_q} <= {8'd0, f_frames_q + 4'd1, 1'b0};
            assert (!out_valid || (f_complete_q && f_out_q < f_in_q));
            assert (!out_valid || f_out_q != f_number || out_byte == f_byte_q);
            assert (!out_end || (f_complete_q && out_intact && f_out_q == f_in_q));
            assert (!ready || !f_complete_q);
            cover (out_end && f_in_q == LONGEST);
            cover (out_end && f_frames_q == 4'd1);
            cover (out_valid && f_out_q == f_number && f_byte_q == 8'd0);
        end
    end
endmodule
`default_nettype wire
