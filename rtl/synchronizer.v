// SPDX-License-Identifier: Apache-2.0
//
// The only place where a signal from outside the clock domain is sampled: two registers. Latency: 2 clocks.
`default_nettype none
module synchronizer #(
    parameter RESET_VALUE = 1'b1
) (
    input  wire clk,
    input  wire rst,
    input  wire i_foreign,
    output wire o_synchronous
);
    reg [1:0] stages_q;
    always @(posedge clk) begin
        if (rst) stages_q <= {2{RESET_VALUE}};
        else stages_q <= {stages_q[0], i_foreign};
    end
    assign o_synchronous = stages_q[1];
endmodule
`default_nettype wire
