// SPDX-License-Identifier: Apache-2.0
//
// Brings a strobe from one clock domain into another. Strobes within some four clocks of the slower domain may become one strobe or none at
// all, so this module is only for rare strobes, such as one a datagram.
`default_nettype none
module strobe_crossing (
    input  wire i_clk,
    input  wire i_strobe,
    input  wire o_clk,
    output wire o_strobe
);
    reg  level_q, seen_q;
    wire level;
    initial {level_q, seen_q} = 2'b00;
    synchronizer #(.RESET_VALUE(1'b0)) crossing (.clk(o_clk), .rst(1'b0), .i_foreign(level_q), .o_synchronous(level));
    always @(posedge i_clk) if (i_strobe) level_q <= !level_q;
    always @(posedge o_clk) seen_q <= level;
    assign o_strobe = level != seen_q;
endmodule
`default_nettype wire
