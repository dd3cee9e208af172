// SPDX-License-Identifier: Apache-2.0
// The product is that of the factor and the bits so far. Numbers of up to F_BITS bits are followed; wide ones are only simulated.
localparam F_BITS = 24;
reg [F_BITS-1:0] f_number_q;
reg [4:0]        f_bits_q;    // that were taken
reg              f_known_q;
`ifdef FORMAL_SERIAL_PRODUCT
reg [FACTOR_BITS-1:0] f_factor_q;
always @(posedge clk) f_factor_q <= i_factor;
`endif
initial f_known_q = 1'b0;
wire [F_BITS+FACTOR_BITS-1:0] f_product = {{FACTOR_BITS{1'b0}}, f_number_q} * {{F_BITS{1'b0}}, i_factor};
always @(posedge clk) begin
    if (i_clear) {f_known_q, f_number_q, f_bits_q} <= {1'b1, {F_BITS{1'b0}}, 5'd0};
    else if (i_step) begin
        f_number_q <= {f_number_q[F_BITS-2:0], i_bit};
        f_bits_q   <= f_bits_q + 1'b1;
    end
`ifdef FORMAL_SERIAL_PRODUCT
    assume (!i_step || f_bits_q < 5'd4);
    if (f_known_q) assume (f_bits_q == 5'd0 || i_factor == f_factor_q);
    if (f_known_q) assert (f_bits_q <= 5'd4 && f_number_q >> f_bits_q == 0);
    if (f_known_q) begin
        assert (o_over == (f_product >> PRODUCT_BITS != 0));
        assert (o_over || {{(F_BITS+FACTOR_BITS-PRODUCT_BITS){1'b0}}, o_product} == f_product);
        cover (o_over);
        cover (!o_over && f_bits_q == 5'd4 && (&o_product));
    end
`else
    if (f_known_q && f_bits_q == 5'd24) begin
        assert (o_over == (f_product >> PRODUCT_BITS != 0));
        assert (o_over || f_product == {{(F_BITS+FACTOR_BITS-PRODUCT_BITS){1'b0}}, o_product});
    end
`endif
end
