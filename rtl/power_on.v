// SPDX-License-Identifier: Apache-2.0
//
// Holds rst from configuration until the PLL has been locked for 2^BITS clocks without a break, and again when it loses the
// lock. The wait also covers what an iCE40 needs after configuration before its block RAM can be read.
`default_nettype none
module power_on #(
    parameter BITS = 12  // 85 µs at 48 MHz
) (
    input  wire clk,
    input  wire i_locked,  // from the PLL, at any time
    output wire rst
);
    reg [BITS:0] count_q;
    wire         locked;
    synchronizer #(.RESET_VALUE(1'b0)) lock (.clk(clk), .rst(1'b0), .i_foreign(i_locked), .o_synchronous(locked));

    initial count_q = {(BITS+1){1'b0}};
    always @(posedge clk) begin
        if (!locked) count_q <= {(BITS+1){1'b0}};
        else if (!count_q[BITS]) count_q <= count_q + 1'b1;
    end
    assign rst = !count_q[BITS];
endmodule
`default_nettype wire
