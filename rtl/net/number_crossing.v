// SPDX-License-Identifier: Apache-2.0
//
// Brings a number from one clock domain into another, never mixed of two. Unlike a Gray code it lets the number jump.
//
// A copy is held still while a toggle goes over and comes back; only then is the next copy taken. o_number follows i_number within some
// three clocks of each domain. Both sides begin with 0.
`default_nettype none
module number_crossing #(
    parameter BITS = 12
) (
    input  wire            i_clk,
    input  wire [BITS-1:0] i_number,
    input  wire            o_clk,
    output reg  [BITS-1:0] o_number
);
    reg            asks_q, told_q;
    reg [BITS-1:0] copy_q;
    wire           asked, answered;
    initial {asks_q, told_q, copy_q, o_number} = {2*BITS+2{1'b0}};
    synchronizer #(.RESET_VALUE(1'b0)) there (.clk(o_clk), .rst(1'b0), .i_foreign(asks_q), .o_synchronous(asked));
    synchronizer #(.RESET_VALUE(1'b0)) back  (.clk(i_clk), .rst(1'b0), .i_foreign(told_q), .o_synchronous(answered));

    always @(posedge i_clk) if (answered == asks_q && copy_q != i_number) begin
        copy_q <= i_number;
        asks_q <= !asks_q;
    end
    always @(posedge o_clk) begin
        if (asked != told_q) o_number <= copy_q;
        told_q <= asked;
    end
endmodule
`default_nettype wire
