// SPDX-License-Identifier: Apache-2.0
//
// Multiplies i_factor by a number that comes bit by bit, the highest first: one adder instead of a multiplier, for whoever has as
// many clocks as the number has bits.
//
// i_clear begins a product; each i_step takes one bit. o_product is the product so far, and o_over says that it has outgrown
// PRODUCT_BITS, which it does not lose again. i_factor must stay meanwhile. FACTOR_BITS is at most PRODUCT_BITS.
`default_nettype none
module serial_product #(
    parameter FACTOR_BITS  = 8,
    parameter PRODUCT_BITS = 10
) (
    input  wire                    clk,
    input  wire                    i_clear,
    input  wire                    i_step,
    input  wire                    i_bit,
    input  wire [FACTOR_BITS-1:0]  i_factor,
    output reg  [PRODUCT_BITS-1:0] o_product,
    output reg                     o_over
);
    generate
        if (FACTOR_BITS > PRODUCT_BITS) factor_bits_out_of_range error();
    endgenerate

    wire [PRODUCT_BITS+1:0] added = i_bit ? {{(PRODUCT_BITS+2-FACTOR_BITS){1'b0}}, i_factor} : {(PRODUCT_BITS+2){1'b0}};
    wire [PRODUCT_BITS+1:0] next  = {1'b0, o_product, 1'b0} + added;

    always @(posedge clk) begin
        if (i_clear) {o_over, o_product} <= {(PRODUCT_BITS+1){1'b0}};
        else if (i_step) begin
            o_over    <= o_over || next[PRODUCT_BITS+1:PRODUCT_BITS] != 2'd0;
            o_product <= next[PRODUCT_BITS-1:0];
        end
    end

`ifdef FORMAL
    `include "formal/serial_product.vh"
`endif
endmodule
`default_nettype wire
