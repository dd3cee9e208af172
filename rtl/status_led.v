// SPDX-License-Identifier: Apache-2.0
//
// Drives a board's one LED, so that a person sees the state without a host: off without a clock, slow blink when idle, on while
// playing, fast blink after a watchdog or guard trip.
//
// It counts carrier cycles instead of clocks, which saves a 24-bit counter.
// SLOW_BIT and FAST_BIT are the bits of that count that blink: at 40 kHz, 15 and 11 are 0.6 and 9.8 blinks a second.
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
