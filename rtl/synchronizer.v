// SPDX-License-Identifier: Apache-2.0
//
// Samples a signal from outside of the clock domain, with two registers against metastability. It is the only module that may.
//
// Latency: 2 clocks, and up to one more until the first edge.
// RESET_VALUE is what it shows during reset: 1 for an idle serial line.
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
