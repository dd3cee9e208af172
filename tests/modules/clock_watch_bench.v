// SPDX-License-Identifier: Apache-2.0
//
// clock_watch beside OSCG.v, for which the bench makes the oscillator's clock.
`default_nettype none
module clock_watch_bench (
    input  wire i_oscillator,
    input  wire i_alive,
    output wire o_running
);
    clock_watch watch (.i_alive(i_alive), .o_running(o_running));
endmodule
`default_nettype wire
