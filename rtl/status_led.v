// SPDX-License-Identifier: Apache-2.0
//
// Drives a board's one LED, so that a person sees the state without a host: slow blink when idle, on while playing, fast blink
// after a watchdog or guard trip. It is bright or faint, not on or off: the pin goes on changing, so that a retriggerable monostable
// on it can tell that the clock has stopped, on boards that have no pin to spare for that.
//
// i_alive changes once a window of the guard. Bright is every second window, faint every sixteenth. It counts carrier cycles
// instead of clocks for the blinking, which saves a 24-bit counter.
// SLOW_BIT and FAST_BIT are the bits of that count that blink: at 40 kHz, 15 and 11 are 0.6 and 9.8 blinks a second.
`default_nettype none
module status_led #(
    parameter SLOW_BIT = 15,
    parameter FAST_BIT = 11
) (
    input  wire clk,
    input  wire rst,
    input  wire i_alive,
    input  wire i_cycle_start,
    input  wire i_playing,
    input  wire i_fault,
    output reg  o_led
);
    reg [SLOW_BIT:0] cycles_q;
    reg              alive_q;
    reg [2:0]        pairs_q;  // of windows
    wire             bright = i_fault ? cycles_q[FAST_BIT] : i_playing || cycles_q[SLOW_BIT];
    always @(posedge clk) begin
        alive_q <= i_alive;
        if (rst) begin
            cycles_q <= {(SLOW_BIT+1){1'b0}};
            pairs_q  <= 3'd0;
        end else begin
            if (i_cycle_start) cycles_q <= cycles_q + 1'b1;
            if (i_alive && !alive_q) pairs_q <= pairs_q + 1'b1;
        end
        o_led <= !rst && alive_q && (bright || pairs_q == 3'd0);
    end
endmodule
`default_nettype wire
