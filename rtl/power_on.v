// SPDX-License-Identifier: Apache-2.0
//
// Makes the reset of a board: rst stays high until the PLL has been locked for 2^BITS clocks without a break, and comes back
// whenever the lock is lost.
//
// Before the lock the clock is not fit to count on. The wait after it is for the iCE40, whose block RAM cannot be read for some
// microseconds after configuration.
// BITS: 12 is 85 µs at 48 MHz.
`default_nettype none
module power_on #(
    parameter BITS = 12
) (
    input  wire clk,
    input  wire i_locked,  // from the PLL, not synchronous to clk
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
