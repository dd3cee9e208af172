// SPDX-License-Identifier: Apache-2.0
//
// In the place of uart_rx for the proof of chain_down: bits are read in any clocks, as any bit clock would.
`default_nettype none
module uart_rx #(
    parameter [19:0] STEP = 20'd20972
) (
    input  wire       clk,
    input  wire       rst,
    input  wire       i_line,
    output reg  [7:0] o_byte,
    output reg        o_valid,
    output wire       o_sample,
    output wire [3:0] o_bits_left
);
    (* anyseq *) wire any;
    reg [3:0] bits_left_q;
    assign o_sample    = bits_left_q != 4'd0 && any;
    assign o_bits_left = bits_left_q;
    always @(posedge clk) begin
        o_valid <= o_sample && bits_left_q == 4'd1 && i_line;
        if (rst) bits_left_q <= 4'd0;
        else if (bits_left_q == 4'd0) bits_left_q <= any && !i_line ? 4'd10 : 4'd0;
        else if (o_sample) begin
            bits_left_q <= bits_left_q == 4'd10 && i_line ? 4'd0 : bits_left_q - 1'b1;
            if (bits_left_q != 4'd10 && bits_left_q != 4'd1) o_byte <= {i_line, o_byte[7:1]};
        end
    end
endmodule
`default_nettype wire
