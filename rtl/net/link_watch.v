// SPDX-License-Identifier: Apache-2.0
//
// Tells when the network's link is lost. The PHY may also stop its clock then. o_lost strobes when a link that was there is lost; o_runs is low
// without a link.
//
// In eth_clk's domain beat_q changes every 32 clocks while i_link is high. In clk's domain the beat must change within 128 clocks, so eth_clk must
// be at least a quarter as fast as clk. The link is there from the second change in time on.
`default_nettype none
module link_watch (
    input  wire eth_clk,
    input  wire i_link,
    input  wire clk,
    input  wire rst,
    output reg  o_lost,
    output reg  o_runs
);
    reg [5:0] count_q;
    reg       beat_q, seen_q;
    reg [7:0] quiet_q;
    wire      beat;
    initial {count_q, beat_q, o_lost, o_runs} = 9'd0;
    always @(posedge eth_clk) begin
        count_q <= i_link ? count_q + 6'd1 : 6'd0;
        beat_q  <= count_q[5];
    end
    synchronizer #(.RESET_VALUE(1'b0)) crossing (.clk(clk), .rst(rst), .i_foreign(beat_q), .o_synchronous(beat));
    always @(posedge clk) begin
        seen_q  <= beat;
        quiet_q <= rst ? 8'd128 : beat != seen_q ? 8'd0 : quiet_q[7] ? quiet_q : quiet_q + 8'd1;
        o_runs  <= !rst && (beat != seen_q ? !quiet_q[7] : o_runs && !quiet_q[7]);
        o_lost  <= !rst && quiet_q == 8'd127 && beat == seen_q && o_runs;
    end
endmodule
`default_nettype wire
