// SPDX-License-Identifier: Apache-2.0
//
// Strobes o_break when the serial line has been low for 20 bits: twice as long as any byte keeps it low. A host sends a break to
// switch off outputs without a frame, and a cable whose other end has lost its power looks the same.
//
// A line that has not been high since reset is not broken but unconnected, so a board that plays by itself needs no cable.
// BIT_CLOCKS (8 to 20000) is the length of a bit, in clocks. The line must have been synchronised.
`default_nettype none
module line_break #(
    parameter BIT_CLOCKS = 50
) (
    input  wire clk,
    input  wire rst,
    input  wire i_line,  // synchronous to clk
    output reg  o_break  // strobe
);
    localparam CLOCKS = 20 * BIT_CLOCKS;
    localparam BITS = $clog2(CLOCKS + 1);
    localparam [BITS-1:0] LAST = CLOCKS[BITS-1:0];

    reg [BITS-1:0] low_q;  // clocks for which the line has been low, up to LAST; LAST also before it was high for the first time
    reg [1:0]      old_q;  // what the synchronizer shows for two clocks after reset is not the line

    always @(posedge clk) begin
        o_break <= !rst && !i_line && low_q == LAST - 1'b1;
        old_q   <= {old_q[0], rst};
        if (rst || old_q != 2'b00) low_q <= LAST;
        else if (i_line) low_q <= {BITS{1'b0}};
        else if (low_q != LAST) low_q <= low_q + 1'b1;
    end

`ifdef FORMAL
    `include "formal/line_break.vh"
`endif
endmodule
`default_nettype wire
