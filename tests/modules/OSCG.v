// SPDX-License-Identifier: Apache-2.0
//
// Stands in for the ECP5's oscillator: the bench's clock.
`default_nettype none
module OSCG #(
    parameter DIV = 0  // of 310 MHz
) (
    output wire OSC
);
    generate
        if (DIV != 128) another_frequency_than_the_test_counts_with error();
    endgenerate
    assign OSC = clock_watch_bench.i_oscillator;
endmodule
`default_nettype wire
