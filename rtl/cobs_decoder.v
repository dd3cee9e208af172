// SPDX-License-Identifier: Apache-2.0
//
// Turns COBS-encoded bytes back into the bytes of frames.
//
// COBS leaves no zero byte within a frame, so a zero always ends one, and a receiver that has lost its place finds it again at
// the next zero; i_break, which comes without a byte, is one, too. Each byte in gives at most one byte out, in the same clock (combinational): o_valid with o_byte for data, or
// o_end at the end of a frame. o_intact says, together with o_end, that the code ended where it should. It has no parameters.
`default_nettype none
module cobs_decoder (
    input  wire       clk,
    input  wire       rst,
    input  wire       i_valid,
    input  wire [7:0] i_byte,
    input  wire       i_break,
    output wire       o_valid,
    output wire [7:0] o_byte,
    output wire       o_end,
    output wire       o_intact
);
    reg [7:0] left_q;  // data bytes before the next code byte
    reg       zero_q;  // a zero byte of the frame follows the data of this group

    wire is_code = left_q == 8'd0;
    assign o_end    = (i_valid && i_byte == 8'd0) || i_break;
    assign o_intact = is_code;
    assign o_valid  = i_valid && !i_break && i_byte != 8'd0 && (!is_code || zero_q);
    assign o_byte   = is_code ? 8'd0 : i_byte;

    always @(posedge clk) begin
        if (rst || o_end) begin
            left_q <= 8'd0;
            zero_q <= 1'b0;
        end else if (i_valid) begin
            left_q <= is_code ? i_byte - 1'b1 : left_q - 1'b1;
            if (is_code) zero_q <= i_byte != 8'hff;
        end
    end

`ifdef FORMAL
    `include "formal/cobs_decoder.vh"
`endif
endmodule
`default_nettype wire
