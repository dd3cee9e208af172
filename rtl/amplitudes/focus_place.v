// SPDX-License-Identifier: Apache-2.0
//
// Finds a focus record in primary memory, and says whether there is one of that index.
//
// Focus record n, from 0 on, has the index RECORDS + 1 + n, and its 4 · (i_last + 1) words begin at word 4 · (i_base + n · (i_last + 1)).
// Both outputs belong to the i_index of two clocks before, because a product and its sums take too long for one; o_refused says
// that n is not below i_count, or that the record ends beyond PRIMARY_WORDS. The inputs beside i_index must not change meanwhile.
// An index that is not above RECORDS means nothing. RECORDS and PRIMARY_WORDS are the core's.
`default_nettype none
module focus_place #(
    parameter RECORDS       = 400,
    parameter PRIMARY_WORDS = 41600
) (
    input  wire        clk,
    input  wire [15:0] i_index,
    input  wire [15:0] i_base,
    input  wire [15:0] i_count,
    input  wire [2:0]  i_last,
    output reg  [27:0] o_first,
    output wire        o_refused
);
    localparam [15:0] FIRST_INDEX = RECORDS[15:0] + 16'd1;
    localparam [27:0] END = PRIMARY_WORDS[27:0];

    wire [3:0]  foci = {1'b0, i_last} + 4'd1;
    reg  [15:0] number_q;
    always @(posedge clk) begin
        number_q <= i_index - FIRST_INDEX;
        o_first  <= {10'd0, i_base, 2'b00} + {6'd0, {4'd0, number_q} * {16'd0, foci}, 2'b00};
    end
    assign o_refused = number_q >= i_count || o_first + {23'd0, i_last, 2'b11} >= END;  // the last word
endmodule
`default_nettype wire
