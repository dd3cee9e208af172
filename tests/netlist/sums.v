// SPDX-License-Identifier: Apache-2.0
//
// Sums and comparisons of every kind that tools/ecp5_map.v maps, in widths from 5 to 9.
`default_nettype none
module sums (
    input  wire [8:0]   i_a,
    input  wire [8:0]   i_b,
    input  wire         i_carry,
    input  wire         i_less,
    output wire [499:0] o_all
);
    localparam [63:0] SOME = 64'h5a3c_96f1_0b27_d4e8;
    genvar n;
    generate
        for (n = 5; n < 10; n = n + 1) begin : width
            wire [n-1:0] a = i_a[n-1:0], b = i_b[n-1:0];
            wire [n-1:0] sum = a + b, rest = a - b, after = a + 1'b1, before = a - 1'b1, either = i_less ? a - b : a + b, beside = a + SOME[n+3:4];
            wire [n:0]   whole = a + b + i_carry, signed_rest = {1'b0, a} - b;
            assign o_all[(n-5)*100 +: 100] = {sum, rest, after, before, either, beside, whole, signed_rest, a < b, a <= b, a > b, a >= b,
                                              a > SOME[n-1:0], a >= SOME[n+7:8], a < SOME[n+1:2], a <= SOME[n+30:31], SOME[n+15:16] >= b};
        end
    endgenerate
endmodule
`default_nettype wire
