// SPDX-License-Identifier: Apache-2.0
//
// Counts carrier periods: the time base in which a host, or another board, says when something is to begin.
//
// i_period strobes once a period, as it begins; o_count is the number of the present one from the next clock on, 0 before the first. 48 bits
// of 40 kHz are 223 years. i_load puts it to i_value instead, in a clock with or without i_period: the period that begins then has
// that number. That is for boards that keep time with another one.
`default_nettype none
module period_count (
    input  wire        clk,
    input  wire        rst,
    input  wire        i_period,
    input  wire        i_load,
    input  wire [47:0] i_value,
    output reg  [47:0] o_count
);
    always @(posedge clk) begin
        if (rst) o_count <= 48'd0;
        else if (i_load) o_count <= i_value;
        else if (i_period) o_count <= o_count + 48'd1;
    end

`ifdef FORMAL
    `include "formal/period_count.vh"
`endif
endmodule
`default_nettype wire
