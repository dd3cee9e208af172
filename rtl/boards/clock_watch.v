// SPDX-License-Identifier: Apache-2.0
//
// Says whether the instrument's clock still runs, for the ECP5: its own oscillator counts, and each change of i_alive starts the
// count anew. When the clock stops, every pin stays as it is, and whatever needs that clock cannot help.
//
// The oscillator runs at 310 MHz / 128 = 2.4 MHz, give or take 15 %. o_running falls when i_alive has not changed for 2^BITS of its
// periods, 0.85 ms, which is eight windows of the guard at 50 MHz and its default. It is not synchronous to the instrument's clock.
`default_nettype none
module clock_watch #(
    parameter BITS = 11
) (
    input  wire i_alive,
    output wire o_running
);
    wire clk, alive;
    OSCG #(.DIV(128)) oscillator (.OSC(clk));
    synchronizer #(.RESET_VALUE(1'b0)) crossing (.clk(clk), .rst(1'b0), .i_foreign(i_alive), .o_synchronous(alive));

    reg            alive_q;
    reg [BITS:0]   quiet_q;
    initial quiet_q = {1'b1, {BITS{1'b0}}};  // not running until it has been seen to
    always @(posedge clk) begin
        alive_q <= alive;
        if (alive != alive_q) quiet_q <= {(BITS+1){1'b0}};
        else if (!quiet_q[BITS]) quiet_q <= quiet_q + 1'b1;
    end
    assign o_running = !quiet_q[BITS];
endmodule
`default_nettype wire
