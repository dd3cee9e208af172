// SPDX-License-Identifier: Apache-2.0
//
// Tells whether there is a link of 1 Gbit/s, by the status that a PHY sends between frames (RGMII's in-band status): bit 0 is the link, bits 2…1 its
// speed, 2 for 1 Gbit/s.
//
// A status counts when READINGS readings in a row agree. So a nibble that was received wrongly does not end the link, and a loss lasts until
// link_watch has seen it. A PHY that sends no status has anything on these lines. Therefore o_link is high until a PHY has reported a link, and
// until then the frames' own sums decide.
`default_nettype none
module link_status #(
    parameter READINGS = 512
) (
    input  wire       clk,
    input  wire       i_dv,      // GMII
    input  wire       i_er,
    input  wire [2:0] i_status,  // the lowest bits of its data
    output reg        o_link
);
    localparam BITS = $clog2(READINGS);
    localparam [BITS-1:0] LAST = READINGS[BITS-1:0] - 1'b1;

    reg            reads_q, up_q;  // what the PHY says in this clock, if it is between frames
    reg            tells_q;        // it has said that there is a link
    reg            before_q;       // the reading before
    reg [BITS-1:0] alike_q;        // readings like it, in a row
    initial {o_link, reads_q, tells_q, before_q, alike_q} = {4'b1000, {BITS{1'b0}}};
    wire counts = reads_q && up_q == before_q && alike_q == LAST;

    always @(posedge clk) begin
        reads_q <= !i_dv && !i_er;
        up_q    <= i_status == 3'b101;
        if (reads_q) begin
            before_q <= up_q;
            if (up_q != before_q) alike_q <= {{BITS-1{1'b0}}, 1'b1};
            else if (alike_q != LAST) alike_q <= alike_q + 1'b1;
        end
        if (counts && up_q) tells_q <= 1'b1;
        if (counts) o_link <= up_q || !tells_q;
    end
endmodule
`default_nettype wire
