// SPDX-License-Identifier: Apache-2.0
//
// What a board's LED says: off without a clock, slow blink idle, on while playing, fast blink after a watchdog or guard trip.
// Counts carrier cycles, which are 25 µs when nothing else was loaded: 0.6 and 9.8 blinks a second.
`default_nettype none
module status_led #(
    parameter SLOW_BIT = 15,
    parameter FAST_BIT = 11
) (
    input  wire clk,
    input  wire rst,
    input  wire i_cycle_start,
    input  wire i_playing,
    input  wire i_fault,
    output reg  o_led
);
    reg [SLOW_BIT:0] cycles_q;
    always @(posedge clk) begin
        if (rst) cycles_q <= {(SLOW_BIT+1){1'b0}};
        else if (i_cycle_start) cycles_q <= cycles_q + 1'b1;
        o_led <= !rst && (i_fault ? cycles_q[FAST_BIT] : i_playing || cycles_q[SLOW_BIT]);
    end
endmodule
`default_nettype wire
