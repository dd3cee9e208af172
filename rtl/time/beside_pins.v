// SPDX-License-Identifier: Apache-2.0
//
// Delays the signals that describe the pins by as much as the pins: by one tick and two clocks.
//
// A tick comes with i_index, its record, and with i_cycle_start if it is the first tick of its cycle. i_tag comes with i_cycle_start;
// behind the pins the tag is 0 between two cycle starts.
`default_nettype none
module beside_pins (
    input  wire        clk,
    input  wire        rst,
    input  wire        i_tick,
    input  wire        i_cycle_start,
    input  wire [15:0] i_index,
    input  wire [1:0]  i_tag,
    output wire        o_cycle_start,
    output wire [1:0]  o_tag,
    output wire [15:0] o_index
);
    reg [2:0]  starts_q;  // the last tick was the first of a cycle, and its tag
    reg [15:0] index_q;   // the record of the last tick
    reg [18:0] beside_0_q, beside_1_q;
    initial {starts_q, index_q, beside_0_q, beside_1_q} = 57'd0;
    always @(posedge clk) begin
        if (rst) {starts_q, index_q, beside_0_q, beside_1_q} <= 57'd0;
        else begin
            if (i_tick) {starts_q, index_q} <= {{3{i_cycle_start}} & {1'b1, i_tag}, i_index};
            beside_0_q <= {{3{i_tick}} & starts_q, i_tick ? index_q : beside_0_q[15:0]};
            beside_1_q <= beside_0_q;
        end
    end
    assign {o_cycle_start, o_tag, o_index} = beside_1_q;
endmodule
`default_nettype wire
